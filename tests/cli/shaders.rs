//! `lodc shaders`: files that stand by themselves. (That they run and are right is what `verify
//! --gpu` proves.)

use crate::support::Folder;

#[test]
fn shaders_come_with_their_guide_and_every_one_is_described() {
    let f = Folder::new();
    f.lodc(["shaders", "-o", "out/shaders", "-q"]).ends(0);
    let guide = String::from_utf8(f.read("out/shaders/ENGINE.md")).expect("text");
    let folder = std::fs::read_dir(f.join("out/shaders")).expect("a folder");
    let names: Vec<_> =
        folder.map(|e| e.expect("an entry").file_name().into_string().expect("a name")).collect();
    assert!(names.len() > 5, "{names:?}");
    for name in names.iter().filter(|name| name.ends_with(".wgsl")) {
        let text = String::from_utf8(f.read(&format!("out/shaders/{name}"))).expect("text");
        assert!(text.starts_with("// ") && text.contains("fn main("), "{name}");
        assert!(guide.contains(&format!("`{name}`")), "the guide does not mention {name}");
    }
    f.lodc(["shaders", "-o", "-"]).fails(2);
    f.file("taken", "");
    f.lodc(["shaders", "-o", "taken"]).fails(4);
}
