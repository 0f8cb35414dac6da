//! One choice of levels in every way of asking for one: the program's tables, `extract`, and the
//! library, whose levels have the input's vertices. The Python and the browser package compare
//! themselves with the program.

use crate::placements::Scene;
use crate::support::{Folder, grid};
use lodc::Select;
use serde_json::{Value, json};

/// Ten scenes: one object and many, small and large ones, scaled by nodes, shown twice, one of an
/// OBJ.
fn scenes() -> Vec<(String, String)> {
    let all = (0..9).map(|number: usize| {
        let sizes: Vec<usize> = (0..=number % 5).map(|i| 4 + (5 * i + 3 * number) % 11).collect();
        let node = |i: usize| {
            let scale = [1.0, 0.25, 4.0][(i + number) % 3];
            let (mesh, scale) = (i % sizes.len(), [scale, scale, 1.0]);
            json!({"mesh": mesh, "translation": [3 * i, 0, 0], "scale": scale})
        };
        let count = sizes.len() + number % 2;
        let nodes: Vec<Value> = (0..count).map(node).collect();
        let roots: Vec<usize> = (0..count).collect();
        let file = Scene::of_rocks(&sizes).file(&roots, &json!({"nodes": nodes}));
        (format!("{number}.gltf"), file)
    });
    all.chain([("plain.obj".to_owned(), grid(20))]).collect()
}

#[test]
fn tables_levels_and_the_library_say_the_same() {
    let f = Folder::new();
    for (name, text) in scenes() {
        let input = f.file(&name, text);
        f.lodc(["build", &name, "-o", "m.lodc", "--models", "none", "-q"]).ends(0);
        let info = f.lodc(["info", "m.lodc", "--json"]).ends(0).json();
        let opened = lodc::open(f.join("m.lodc")).expect("a file");
        let built = lodc::build(&input).models(&[]).run().expect("a mesh");
        let objects = info["objects"].as_array().expect("objects").len();
        for share in [0.5, 0.1, 0.01] {
            let ratio = share.to_string();
            let level = |input: &str| {
                let how = ["--no-refit", "-o", "l.glb", "--json", "-q"];
                let args = ["extract", input, "--ratio", &ratio];
                f.lodc(args.iter().chain(&how)).ends(0).json()
            };
            let (of_file, of_mesh) = (level("m.lodc"), level(&name));
            let facts = |level: &Value| -> Vec<(u64, u64)> {
                let object = |o: &Value| (o["lod"].as_u64(), o["triangles"].as_u64());
                let objects = level["objects"].as_array().expect("objects").iter().map(object);
                objects.map(|(lod, n)| lod.zip(n).expect("numbers")).collect()
            };
            assert_eq!(facts(&of_file), facts(&of_mesh), "{name} at {share}");
            for file in [&opened, &built] {
                let level = file.level(Select::Ratio(share)).expect("a level");
                let own: Vec<(u64, u64)> = level
                    .objects()
                    .map(|o| (u64::from(o.lod()), o.indices().len() as u64))
                    .collect();
                assert_eq!(own, facts(&of_file), "{name} at {share}");
                assert_eq!(Some(level.error()), of_file["error"].as_f64(), "{name} at {share}");
            }
        }
        // The table of `info` of one object, that of the pages and of `build`.
        if objects == 1 {
            let rows = info["objects"][0]["lods"].as_array().expect("a table");
            for (row, share) in rows[1..].iter().zip(["0.5", "0.25", "0.1", "0.05", "0.01"]) {
                let how = ["--no-refit", "-o", "l.glb", "--json", "-q"];
                let args = ["extract", "m.lodc", "--ratio", share];
                let level = f.lodc(args.iter().chain(&how)).ends(0).json();
                assert_eq!(row["triangles"], level["triangles"], "{name} at {share}");
                assert_eq!(row["world_error"], level["error"], "{name} at {share}");
            }
        }
    }
}
