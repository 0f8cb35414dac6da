//! Nothing is read from outside the asset's own folder, and nothing is waited for.

use crate::support::{Folder, grid, scene};

/// Ways out of a folder, as a file might spell them.
const WAYS_OUT: &[&str] = &[
    "../secret.bin",
    "../../etc/passwd",
    "sub/../../secret.bin",
    "%2e%2e/secret.bin",
    "..%2fsecret.bin",
    "..\\secret.bin",
    "/etc/passwd",
    "//etc/passwd",
    "file:///etc/passwd",
    "FILE:///etc/passwd",
    "http://127.0.0.1:9/x.bin",
    "https://127.0.0.1/x.bin",
    "ftp://127.0.0.1/x.bin",
    "link.bin",
    "pipe",
    "/dev/zero",
    "a%00b",
    "%FF",
    "C:\\secret.bin",
];

/// A folder with a secret beside it and a link and a pipe inside.
fn trap() -> Folder {
    let f = Folder::new();
    f.file("secret.bin", [7; 36]);
    f.file("asset/other.txt", "");
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(f.join("secret.bin"), f.join("asset/link.bin")).expect("a link");
        let made = std::process::Command::new("mkfifo")
            .arg(f.join("asset/pipe"))
            .status()
            .expect("mkfifo is there");
        assert!(made.success());
    }
    f
}

fn gltf(uri: &str) -> String {
    serde_json::json!({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"byteLength": 36, "uri": uri}]
    })
    .to_string()
}

/// A door that must stay shut: whoever connects is noticed.
struct Door(std::net::TcpListener);

impl Door {
    fn new() -> Self {
        let listener = std::net::TcpListener::bind("127.0.0.1:0").expect("a port is free");
        listener.set_nonblocking(true).expect("it can be asked without waiting");
        Self(listener)
    }
    fn address(&self) -> String {
        format!("http://{}/x.bin", self.0.local_addr().expect("it is bound"))
    }
    fn assert_nobody_came(&self) {
        let caller = self.0.accept().map(|(_, who)| who).map_err(|e| e.kind());
        assert_eq!(caller, Err(std::io::ErrorKind::WouldBlock));
    }
}

#[test]
fn nothing_connects_to_anything() {
    let (f, door) = (trap(), Door::new());
    let at = door.address();
    f.file("asset/a.gltf", gltf(&at));
    f.lodc(["build", "asset/a.gltf"]).fails(3);
    f.file("asset/a.obj", format!("mtllib {at}\nusemtl m\n{}", grid(2)));
    f.lodc(["build", "asset/a.obj", "-o", "asset/a.lodc", "-q"]);
    f.file("asset/a.mtl", format!("newmtl m\nmap_Kd {at}\n"));
    f.file("asset/b.obj", format!("mtllib a.mtl\nusemtl m\n{}", grid(2)));
    f.lodc(["build", "asset/b.obj", "-o", "asset/b.lodc", "-q"]).ends(0);
    f.lodc(["extract", "asset/b.lodc", "--ratio", "0.5", "-o", "b.glb", "-q"]);
    f.lodc(["build", "asset/a.gltf", "--allow-path", "/"]).fails(3);
    door.assert_nobody_came();
}

/// Whether every file that the dependencies name is in the asset's folder: what a name leads to on
/// another machine is looked for there by its last part.
fn is_inside(f: &Folder) -> bool {
    let text = String::from_utf8_lossy(&f.read("deps.d")).into_owned();
    let outside = ["secret.bin", "passwd"].map(|name| text.replace(&format!("asset/{name}"), ""));
    !outside[0].contains("secret") && !outside[1].contains("passwd")
}

#[test]
fn textures_are_named_and_never_opened() {
    let f = trap();
    let canary = "the canary of the secret file";
    f.file("secret.bin", canary);
    for way in WAYS_OUT.iter().filter(|way| !way.contains('%')) {
        f.file("asset/a.mtl", format!("newmtl m\nmap_Kd {way}\nmap_Bump -bm 1 {way}\n"));
        f.file("asset/a.obj", format!("mtllib a.mtl\nusemtl m\n{}", grid(2)));
        let mut scene: serde_json::Value = serde_json::from_str(&scene(&[1.0], 2)).expect("sound");
        scene["images"] = serde_json::json!([{"uri": way}]);
        scene["textures"] = serde_json::json!([{"source": 0}]);
        scene["materials"] =
            serde_json::json!([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]);
        f.file("asset/b.gltf", scene.to_string());
        for input in ["asset/a.obj", "asset/b.gltf"] {
            let built = f.lodc(["build", input, "-o", "x.lodc", "--depfile", "deps.d", "-q"]);
            assert!(matches!(built.status, Some(0 | 3)), "{way}: {built:?}");
            if built.status == Some(3) {
                continue;
            }
            for out in ["x.glb", "x.gltf", "x.obj"] {
                let run = f.lodc(["extract", "x.lodc", "--ratio", "0.5", "-o", out, "-q"]);
                // 2: the last part of a name is that of a file that would be written.
                assert!(matches!(run.status, Some(0 | 2 | 3 | 4)), "{way}: {run:?}");
            }
            for name in f.names().iter().filter(|n| n.starts_with("x.") || *n == "deps.d") {
                let bytes = f.read(name);
                let holds = |text: &str| bytes.windows(text.len()).any(|w| w == text.as_bytes());
                assert!(!holds(canary) && !holds("root:"), "{way} came into {name}");
                assert!(name != "deps.d" || is_inside(&f), "{way} was read for {name}");
            }
        }
    }
}

#[test]
fn no_buffer_leads_out_of_the_folder() {
    let f = trap();
    for way in WAYS_OUT {
        f.file("asset/a.gltf", gltf(way));
        let run = f.lodc(["build", "asset/a.gltf", "-o", "asset/a.lodc", "--depfile", "deps.d"]);
        let run = run.fails(3);
        assert!(!run.err.contains("root:"), "{way}: {}", run.err);
        assert!(!f.has("asset/a.lodc") && !f.join("deps.d").exists_with("secret"), "{way}");
    }
}

#[test]
fn a_folder_that_is_allowed_may_be_read() {
    let f = trap();
    f.file("asset/a.gltf", gltf("../secret.bin"));
    f.lodc(["build", "asset/a.gltf", "-q"]).ends(3);
    f.lodc(["build", "asset/a.gltf", "-o", "asset/a.lodc", "-q", "--allow-path", "."]).ends(0);
}

#[test]
fn no_material_library_leads_out_of_the_folder_and_a_missing_one_stops_nothing() {
    let f = trap();
    for way in WAYS_OUT.iter().copied().chain(["missing.mtl"]) {
        f.file("asset/a.obj", format!("mtllib {way}\nusemtl m\n{}", grid(2)));
        let run = f.lodc(["build", "asset/a.obj", "-o", "asset/a.lodc", "--depfile", "deps.d"]);
        assert!(matches!(run.status, Some(0 | 3)), "{way}: {}", run.err);
        assert!(!f.has("deps.d") || is_inside(&f), "{way}");
        assert!(!run.err.contains("root:"), "{way}: {}", run.err);
        assert!(run.err.contains("warning") || run.status == Some(3), "{way}: {}", run.err);
    }
}

#[test]
fn devices_pipes_and_folders_are_no_meshes() {
    let f = trap();
    for input in ["asset/pipe", "/dev/zero", "asset", "missing.obj"] {
        let run = f.lodc(["build", input, "-o", "x"]);
        assert_eq!(run.status, Some(3), "{input}: {}", run.err);
        assert_eq!(run.err.lines().count(), 1, "{input}: {}", run.err);
    }
}

#[test]
fn names_cannot_forge_messages() {
    let f = Folder::new();
    let run = f.lodc(["build", "a\nlodc: all is well\u{1b}[2J.obj"]).fails(3);
    assert!(!run.err.contains('\u{1b}'), "{}", run.err);
}

/// Returns whether a file exists and has this text in it.
trait ExistsWith {
    fn exists_with(&self, text: &str) -> bool;
}

impl ExistsWith for std::path::PathBuf {
    fn exists_with(&self, text: &str) -> bool {
        std::fs::read_to_string(self).is_ok_and(|all| all.contains(text))
    }
}
