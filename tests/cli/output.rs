//! Output appears whole or not at all, whatever happens meanwhile.

use crate::support::{Folder, LODC, grid};
use std::io::{Read, Write};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

#[test]
fn a_failed_run_leaves_what_stood_there() {
    let f = Folder::new();
    f.file("bad.obj", "v 0 0 0\nf 1 2 3\n");
    f.file("good.obj", grid(3));
    f.file("bad.lodc", "precious");
    f.lodc(["build", "bad.obj", "-o", "bad.lodc"]).fails(3);
    assert_eq!(f.read("bad.lodc"), b"precious");
    assert_eq!(f.names(), ["bad.lodc", "bad.obj", "good.obj"], "and nothing beside it");
    f.lodc(["build", "good.obj", "-o", "bad.lodc", "-q"]).ends(0);
    assert_ne!(f.read("bad.lodc"), b"precious");
}

/// The buffer of an input has a name that outputs may have, too.
#[test]
fn no_output_replaces_a_file_of_an_input() {
    let f = Folder::new();
    let fixtures = concat!(env!("CARGO_MANIFEST_DIR"), "/../fixtures/");
    let read = |name: &str| std::fs::read(format!("{fixtures}{name}")).expect("a fixture");
    let text = String::from_utf8(read("cube.gltf")).expect("text");
    f.file("cube.gltf", text.replace("cube.bin", "model.bin"));
    f.file("model.bin", read("cube.bin"));
    let replacing: [&[&str]; 4] = [
        &["extract", "cube.gltf", "--ratio", "1", "-o", "model.gltf"],
        &["chain", "cube.gltf", "-o", "model.gltf"],
        &["build", "cube.gltf", "-o", "model.bin"],
        &["render", "cube.gltf", "-o", "model.bin"],
    ];
    for args in replacing {
        f.lodc(args).fails(2);
        assert_eq!(f.read("model.bin"), read("cube.bin"), "{args:?}");
    }
    // Names that say what is not in the file, and files that are written twice.
    let refused: [&[&str]; 6] = [
        &["build", "cube.gltf", "-o", "x.glb"],
        &["render", "cube.gltf", "-o", "x.jpg"],
        &["view", "cube.gltf", "-o", "x.png"],
        &["build", "cube.gltf", "-o", "x.lodc", "--junit", "x.lodc"],
        &["build", "cube.gltf", "-o", "x.lodc", "--junit", "r.txt", "--depfile", "r.txt"],
        &["compare", "cube.gltf", "cube.gltf", "--heatmap", "z.png", "--junit", "z.png"],
    ];
    for args in refused {
        f.lodc(args).fails(2);
    }
    // What gives options is among the dependencies.
    f.file("lodc.toml", "[defaults]\nweld = 0.001\n");
    f.lodc(["build", "cube.gltf", "-o", "x.lodc", "--depfile", "x.d"]).ends(0);
    let rule = String::from_utf8(f.read("x.d")).expect("text");
    assert!(rule.contains("lodc.toml") && rule.contains("model.bin"), "{rule}");
    f.lodc(["extract", "x.lodc", "--ratio", "0.5", "-o", "y.glb", "--metric", "hybrid"]).fails(2);
    f.lodc(["extract", "cube.gltf", "--ratio", "1", "-o", "other.gltf"]).ends(0);
    f.lodc(["extract", "cube.gltf", "--ratio", "1", "-o", "x.vrm", "--format", "glb"]).ends(0);
}

#[test]
fn output_that_cannot_be_written_is_4() {
    let f = Folder::new();
    f.file("good.obj", grid(3));
    f.file("file", "no folder");
    for out in ["missing/a.lodc", "file/a.lodc", "/proc/a.lodc"] {
        f.lodc(["build", "good.obj", "-o", out]).fails(4);
    }
    f.lodc(["build", "good.obj", "-o", "good.lodc", "-q"]).ends(0);
    f.lodc(["extract", "good.lodc", "--ratio", "1", "-o", "missing/a.glb"]).fails(4);
    if cfg!(target_os = "linux") {
        let full = || {
            Stdio::from(std::fs::File::options().write(true).open("/dev/full").expect("/dev/full"))
        };
        for args in [
            vec!["info", "good.lodc"],
            vec!["build", "good.obj", "-o", "-", "-q"],
            vec!["verify", "good.lodc"],
        ] {
            let output = Command::new(LODC)
                .args(&args)
                .current_dir(f.path())
                .stdout(full())
                .output()
                .expect("it starts");
            assert_eq!(output.status.code(), Some(4), "{args:?}");
        }
    }
}

#[cfg(unix)]
#[test]
fn a_read_only_folder_is_4_and_keeps_its_file() {
    use std::os::unix::fs::PermissionsExt;
    let f = Folder::new();
    f.file("good.obj", grid(3));
    f.file("locked/good.lodc", "precious");
    let mode = |m| {
        std::fs::set_permissions(f.join("locked"), std::fs::Permissions::from_mode(m))
            .expect("my folder");
    };
    mode(0o555);
    if std::fs::write(f.join("locked/probe"), "").is_ok() {
        // The superuser writes everywhere.
        eprintln!("SKIPPED: read-only folders do not stop this user");
    } else {
        f.lodc(["build", "good.obj", "-o", "locked"]).fails(4);
    }
    mode(0o755);
    assert_eq!(f.read("locked/good.lodc"), b"precious");
}

#[test]
fn a_reader_that_leaves_early_is_no_error() {
    let f = Folder::new();
    f.file("good.obj", grid(3));
    f.lodc(["build", "good.obj", "-o", "good.lodc", "-q"]).ends(0);
    for args in [
        vec!["info", "good.lodc"],
        vec!["info", "good.lodc", "--json"],
        vec!["completions", "bash"],
        vec!["--help"],
    ] {
        let mut command = Command::new(LODC);
        command.args(&args).current_dir(f.path()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().expect("it starts");
        drop(child.stdout.take());
        let mut err = String::new();
        child.stderr.take().expect("a pipe").read_to_string(&mut err).expect("text");
        let status = child.wait().expect("it ends");
        assert_eq!((status.code(), err.as_str()), (Some(0), ""), "{args:?}");
    }
}

/// A build of what comes on standard input, which waits for more of it.
#[cfg(unix)]
fn waiting_build(f: &Folder) -> Child {
    let mut command = Command::new(LODC);
    command.args(["build", "-", "-o", "g.lodc", "-q"]).current_dir(f.path());
    command.stdin(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts")
}

/// Ends a build at many moments, by a signal that cannot be caught, and looks at what is left.
#[cfg(unix)]
#[test]
fn a_killed_build_leaves_the_old_file_or_the_new_one() {
    let f = Folder::new();
    f.file("g.obj", grid(60));
    let start = Instant::now();
    f.lodc(["build", "g.obj", "-o", "new.lodc", "-q"]).ends(0);
    let whole = start.elapsed();
    let (old, new) = (b"precious".to_vec(), f.read("new.lodc"));
    f.file("g.lodc", &old);
    let mut child = waiting_build(&f);
    child.kill().expect("it waits");
    child.wait().expect("it ends");
    assert!(f.read("g.lodc") == old, "it had no input yet");
    let moments = lodc_fixtures::seeds(6, 12);
    for moment in moments.clone() {
        f.file("g.lodc", &old);
        let mut command = Command::new(LODC);
        command
            .args(["build", "g.obj", "-o", "g.lodc", "-q"])
            .current_dir(f.path())
            .stdin(Stdio::null());
        let mut child = command.spawn().expect("it starts");
        // A little past the end too: the moment of the rename is what matters most.
        let share = 1.2 * moment as f64 / moments.end as f64;
        std::thread::sleep(whole.mul_f64(share));
        let _ = child.kill();
        child.wait().expect("it ends");
        let now = f.read("g.lodc");
        assert!(now == old || now == new, "neither the old nor the new file at moment {moment}");
    }
    f.lodc(["build", "g.obj", "-o", "g.lodc", "-q"]).ends(0);
    assert_eq!(
        f.names(),
        ["g.lodc", "g.obj", "new.lodc"],
        "the next run removes what killed ones left"
    );
}

/// Waits until a process has its handlers: without, a signal ends it as it would any process.
#[cfg(target_os = "linux")]
fn wait_for_handlers(process: u32) {
    // SIGINT and SIGTERM.
    let wanted = 1 << (2 - 1) | 1 << (15 - 1);
    let caught = || {
        let status = std::fs::read_to_string(format!("/proc/{process}/status")).expect("it runs");
        let mask = status.lines().find_map(|line| line.strip_prefix("SigCgt:")).expect("a mask");
        u64::from_str_radix(mask.trim(), 16).expect("a number")
    };
    while caught() & wanted != wanted {
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[cfg(target_os = "linux")]
#[test]
fn an_interrupted_build_leaves_nothing_partial() {
    let f = Folder::new();
    f.file("g.lodc", "precious");
    for signal in ["INT", "TERM"] {
        let mut child = waiting_build(&f);
        let pipe = child.stdin.as_mut().expect("a pipe was asked for");
        pipe.write_all(grid(50).as_bytes()).expect("it reads");
        wait_for_handlers(child.id());
        let kill = format!("kill -{signal} {}", child.id());
        assert!(Command::new("sh").args(["-c", &kill]).status().expect("a shell").success());
        let mut err = String::new();
        child.stderr.take().expect("a pipe").read_to_string(&mut err).expect("text");
        assert_eq!(child.wait().expect("it ends").code(), Some(130), "{err}");
        assert_eq!(f.read("g.lodc"), b"precious");
        assert_eq!(f.names(), ["g.lodc"]);
    }
}
