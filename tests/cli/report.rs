//! `lodc report`: one page for people who approve assets.

use crate::support::{Folder, grid, scene};

const PART: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../fixtures/machine_part.glb");

fn page(f: &Folder, name: &str) -> String {
    String::from_utf8(f.read(name)).expect("a page is text")
}

#[test]
fn a_report_shows_levels_charts_storage_and_checks() {
    let f = Folder::new();
    f.lodc(["build", PART, "-o", "part.lodc", "-q"]).ends(0);
    f.lodc(["report", "part.lodc", "-o", "r.html", "--title", "a <part>", "-q"]).ends(0);
    let page = page(&f, "r.html");
    assert!(page.contains("<h1>a &lt;part&gt;</h1>"));
    for word in ["480 triangles", "240 triangles", "✓", "interactive", "speed", "masking", "None."]
    {
        assert!(page.contains(word), "{word}");
    }
    // Four sides of six levels, and of all but the input also the distance from it and back.
    assert_eq!(page.matches("src=\"data:image/png;base64,").count(), 4 * 6 + 2 * 4 * 5);
    assert_eq!(page.matches("distance of the input from").count(), 4 * 5);
    // Colours end where the error does, and the last level says what it does not show.
    let quarter = page.split("<h3>25 %</h3>").nth(1).expect("a level");
    let between = |before: &str, after: char| {
        let (_, rest) = quarter.split_once(before).expect("it is there");
        rest.split(after).next().expect("text").to_owned()
    };
    let error = between("<dt>Error</dt><dd>", ' ');
    assert_eq!(between("<i></i><span>", '<'), error);
    assert!(page.contains("of the visible surface is gone"));
    assert_eq!(page.matches("class=\"curve\"").count(), 2);
    assert!(!page.contains("http") && !page.contains("<script"), "it needs no network, no script");
    assert!(!page.contains("different"), "a check failed");
    f.lodc(["report", "part.lodc", "-o", "again.html", "--title", "a <part>", "-q"]).ends(0);
    assert_eq!(f.read("r.html"), f.read("again.html"), "the same bytes for the same input");
}

#[test]
fn a_mesh_of_several_objects_is_reported_too_and_nothing_is_refused() {
    let f = Folder::new();
    f.file("scene.gltf", scene(&[1.0, 3.0], 8));
    f.lodc(["report", "scene.gltf", "-o", "r.html", "-q"]).ends(0);
    assert!(page(&f, "r.html").contains("2 objects"));
    f.file("g.obj", grid(3));
    f.lodc(["report", "missing.obj", "-o", "x.html"]).fails(3);
    f.lodc(["report", "g.obj", "-o", "-", "--depfile", "d"]).fails(2);
    f.file("points.obj", "v 0 0 0\np 1\n");
    assert!(f.lodc(["report", "points.obj", "-o", "x.html"]).status != Some(0));
    assert!(!f.has("x.html"));
}
