//! The example draws what the CPU says.

use super::*;
use lodc_formats::lodc::{Layout, LodFile, LodObject, write};
use lodc_formats::{Document, ObjDocument, ObjectInfo, Source, SourceFormat, SubmeshInfo};
use lodc_lod::interactive::view::{Criterion, ViewQuery, Views, filtered};
use lodc_mesh::Simplified;
use lodc_plan::VertexRecords;
use std::sync::Arc;

fn file(simplified: Simplified, layout: Layout) -> Vec<u8> {
    let submesh = |i| SubmeshInfo { name: String::new(), material: None, document_primitive: i };
    let info = ObjectInfo {
        name: "part".to_owned(),
        submeshes: (0..simplified.mesh().submeshes().len() as u32).map(submesh).collect(),
        world_scale: 1.0,
        document_mesh: 0,
        poses: vec![],
    };
    let file: LodFile = LodFile {
        source: Source { format: SourceFormat::Obj, content_hash: 0 },
        document: Document::Obj(ObjDocument::default()),
        objects: vec![LodObject { info, simplified: Arc::new(simplified), models: vec![] }],
        layout,
        made_from: None,
        left_out: vec![],
    };
    write(&file, |model, _| model.clone())
}

fn simplified(name: &str) -> Simplified {
    let mesh = lodc_fixtures::named(name).expect("a shape");
    lodc_simplify::simplify(&mesh, &lodc_simplify::Options::DEFAULT, &|_, _| {})
}

/// Triangles that the CPU shows by view.
fn by_view(simplified: &Simplified, camera: &Camera, pixels: f32) -> u32 {
    let mesh = simplified.mesh();
    let views = Views::new(simplified, VertexRecords::positions(mesh));
    let criterion = Criterion::ScreenError { eye: camera.eye, slope: camera.slope(pixels) };
    let shown = views.show(&ViewQuery { criterion, morph: false });
    filtered(mesh, mesh.triangles(), &shown.vertices, 3).indices.len() as u32 / 3
}

#[test]
fn pictures_show_the_triangles_that_the_cpu_shows() {
    let Some(gpu) = Gpu::open() else {
        assert!(
            !lodc_fixtures::all_asked(),
            "a device must be there where all tests are asked for"
        );
        println!("SKIPPED: no graphics device");
        return;
    };
    let folder = std::env::temp_dir().join(format!("lodc-host-{}", std::process::id()));
    for name in ["machine_part", "torus", "icosphere"] {
        let simplified = simplified(name);
        let bytes = file(simplified.clone(), Layout::Gpu);
        let drawn = draw_all(&gpu, &bytes, &folder).expect("a sound file");
        let camera = Camera::around(simplified.mesh());
        let collapses = simplified.collapses();
        let everywhere = SHARES.map(|share| {
            let most = share * f64::from(collapses.parts().triangles);
            simplified.triangles_at(collapses.lod_for_triangles(most as u32)).len() as u32
        });
        let views = PIXELS.map(|pixels| by_view(&simplified, &camera, pixels));
        let counts: Vec<u32> = drawn.iter().map(|d| d.triangles).collect();
        assert_eq!(counts, [&everywhere[..], &views[..]].concat(), "{name}");
        assert!(everywhere[0] > everywhere[1] && views[0] > views[1], "{name}: {counts:?}");
        for level in &drawn {
            // But for a last handful, levels cover most of what LOD 0 covers.
            assert!(level.covered > 2_000, "{name}: {level:?}");
            let most = 2 * level.covered > drawn[0].covered;
            assert!(most || level.triangles < 10, "{name}: {level:?}");
            let file = folder.join(&level.name).with_extension("png");
            let png = std::fs::read(file).expect("it was written");
            assert!(png.starts_with(b"\x89PNG"));
        }
    }
    std::fs::remove_dir_all(&folder).expect("my own folder");
}

#[test]
fn a_file_of_the_packed_layout_is_refused_in_a_line() {
    let bytes = file(simplified("cube"), Layout::Packed);
    let refused = Mapped::read(&bytes).err().expect("nothing to upload");
    assert!(refused.to_string().contains("--layout gpu"));
    assert!(Mapped::read(b"junk").is_err());
}

/// The page, and what it may quote.
const PAGE: &str = include_str!("../../../../docs/ENGINE.md");
const SOURCES: [&str; 4] = [
    include_str!("levels.rs"),
    include_str!("view.rs"),
    include_str!("picture.rs"),
    include_str!("../../../web/example/webgpu.js"),
];

/// The lines of a text that are not empty, without what stands before and behind them.
fn lines(text: &str) -> Vec<&str> {
    text.lines().map(str::trim).filter(|line| !line.is_empty()).collect()
}

#[test]
fn the_page_quotes_the_hosts_as_they_are() {
    let (page, _) = PAGE.split_once("### Levels in a GLB").expect("the last section has no host");
    let sources = SOURCES.map(lines);
    let fenced = page.split("```").skip(1).step_by(2);
    let code = fenced.filter_map(|b| b.strip_prefix("rust\n").or(b.strip_prefix("js\n")));
    let quotes: Vec<Vec<&str>> = code.map(lines).collect();
    for quote in &quotes {
        let found = sources.iter().any(|s| s.windows(quote.len()).any(|w| w == quote));
        assert!(found, "no host has these lines: {quote:#?}");
    }
    assert!(quotes.len() >= 8, "{}", quotes.len());
}
