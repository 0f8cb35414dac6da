//! Places of image files: inside, beside under their name, beside under another one.

use super::*;
use crate::images::{ImagePlace, TextureMode};
use crate::obj::mtl;
use crate::{GltfDocument, Limits, ObjDocument, ObjMaterial};
use std::fs;
use std::path::PathBuf;

const PNG: &[u8] = b"\x89PNG\r\n\x1a\n and so on";

struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path =
            std::env::temp_dir().join(format!("lodc-textures-{}-{name}", std::process::id()));
        fs::create_dir_all(path.join("in/wood")).expect("a folder");
        fs::create_dir_all(path.join("out")).expect("a folder");
        fs::write(path.join("in/wood/a b.png"), PNG).expect("a file");
        Self(path)
    }
    fn assets(&self) -> Assets {
        Assets::new(&self.0.join("in/model.gltf"), &[], Limits::DEFAULT)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn gltf() -> Document {
    let json = r#"{"asset":{"version":"2.0"},
        "images":[{"uri":"wood/a%20b.png"},{"uri":"gone.png"},
        {"uri":"https://example.org/a.png"}]}"#;
    Document::Gltf(GltfDocument::new(json.to_owned(), vec![]))
}

#[test]
fn images_are_read_once_and_a_missing_one_is_a_warning() {
    let folder = Folder::new("read");
    let textures = Textures::read(&gltf(), &mut folder.assets()).expect("a sound document");
    assert_eq!(textures.files.keys().collect::<Vec<_>>(), ["wood/a b.png"]);
    assert_eq!(textures.warnings.len(), 1, "{:?}", textures.warnings);
    assert!(textures.warnings[0].contains("gone.png"), "{:?}", textures.warnings);
    let line = |l: &str| ObjMaterial { name: l.to_owned(), lines: vec![l.to_owned()] };
    let lines = ["map_Kd -s 2 2 wood\\a b.png", "bump -bm 0.3 wood/a b.png", "Kd 1 1 1"].map(line);
    let obj = Document::Obj(ObjDocument {
        libraries: vec![],
        materials: lines.to_vec(),
        ..ObjDocument::default()
    });
    let textures = Textures::read(&obj, &mut folder.assets()).expect("nothing to damage");
    assert_eq!(textures.files.keys().collect::<Vec<_>>(), ["wood/a b.png"]);
}

#[test]
fn a_copy_keeps_its_name_unless_another_file_has_it() {
    let folder = Folder::new("copy");
    let placed = || {
        let textures = Textures::read(&gltf(), &mut folder.assets()).expect("sound");
        textures.placed(TextureMode::Copy, &folder.0.join("out/m.gltf"))
    };
    let first = placed();
    assert_eq!(first.copies.len(), 1);
    assert_eq!(first.copies[0].path, folder.0.join("out/wood/a b.png"));
    fs::create_dir_all(folder.0.join("out/wood")).expect("a folder");
    fs::write(&first.copies[0].path, PNG).expect("a file");
    assert!(placed().copies.is_empty(), "the same bytes are there already");
    fs::write(&first.copies[0].path, b"other").expect("a file");
    let other = placed();
    let name = other.copies[0].path.to_string_lossy().into_owned();
    assert!(name.contains("wood/a b-") && name.ends_with(".png"), "{name}");
    assert!(other.warnings[0].contains("another file"), "{:?}", other.warnings);
    let place = other.of("wood/a b.png");
    assert!(matches!(place, Some(ImagePlace::Beside(p)) if p.starts_with("wood/a b-")));
}

#[test]
fn only_known_images_are_embedded() {
    let folder = Folder::new("embed");
    fs::write(folder.0.join("in/gone.png"), b"no image").expect("a file");
    let textures = Textures::read(&gltf(), &mut folder.assets()).expect("sound");
    let placed = textures.placed(TextureMode::Embed, &folder.0.join("out/m.glb"));
    assert!(matches!(
        placed.of("wood/a b.png"),
        Some(ImagePlace::Inside { mime: "image/png", .. })
    ));
    assert!(placed.of("gone.png").is_none() && placed.warnings.len() == 1);
}

#[test]
fn a_line_gets_another_file_behind_its_options() {
    let line = "map_Kd -o 1 2 -clamp on my wood.png ";
    assert_eq!(mtl::file(line), Some("my wood.png"));
    assert_eq!(mtl::with_file(line, "x.png"), "map_Kd -o 1 2 -clamp on x.png");
    for none in ["Kd 1 0 0", "map_Kd", "map_aat on", "newmtl map_Kd x"] {
        assert_eq!(mtl::file(none), None, "{none}");
    }
}
