use super::*;
use crate::testing::{Scratch, say};

fn limits(file_bytes: u64, total_bytes: u64) -> Limits {
    Limits { file_bytes, total_bytes, ..Limits::DEFAULT }
}

fn asset(scratch: &Scratch) -> Assets {
    Assets::new(&scratch.path("asset/main.obj"), &[], Limits::DEFAULT)
}

fn layout(name: &str) -> Scratch {
    let scratch = Scratch::new(name);
    scratch.write("asset/main.obj", b"main");
    scratch.write("asset/sub/inner.mtl", b"inner");
    scratch.write("secret.mtl", b"secret");
    scratch.write("asset-other/near.mtl", b"near");
    scratch
}

#[test]
fn files_of_the_own_folder_are_read_and_listed_once() {
    let scratch = layout("assets-own");
    let mut assets = asset(&scratch);
    assert_eq!(assets.read_main().expect("main"), b"main");
    assert_eq!(assets.read_reference("sub/inner.mtl").expect("inner"), b"inner");
    assert_eq!(assets.read_reference("./sub/../sub/inner.mtl").expect("dots inside"), b"inner");
    assert_eq!(assets.read_reference("sub/inner.mtl").expect("inner again"), b"inner");
    assert!(assets.read_reference("sub/none.mtl").is_err());
    assert_eq!(
        assets.files().read_files()[..2],
        [scratch.path("asset/main.obj"), scratch.path("asset/sub/inner.mtl")]
    );
    assert_eq!(assets.files().read_files().len(), 3);
    assert_eq!(assets.files().absent(), [scratch.path("asset/sub/none.mtl")]);
}

#[test]
fn references_out_of_the_folder_are_forbidden() {
    let scratch = layout("assets-escape");
    let absolute = scratch.path("secret.mtl").display().to_string();
    let list = [
        "../secret.mtl",
        "sub/../../secret.mtl",
        "../asset-other/near.mtl",
        "../../../../../../../../../../etc/passwd",
        "/etc/passwd",
        absolute.as_str(),
        "file:///etc/passwd",
        "file:main.obj",
        "http://127.0.0.1:9/x",
        "HTTPS://example.invalid/x",
        "data:text/plain,x",
        "C:\\windows\\win.ini",
        "sub/inner.mtl\0",
        "//etc/passwd",
    ];
    for reference in list {
        let error = asset(&scratch).read_reference(reference).expect_err(reference);
        assert_eq!(error.fault, Fault::Forbidden, "{reference}: {error}");
    }
}

#[test]
fn things_that_are_not_files_are_unreadable() {
    let scratch = layout("assets-kinds");
    for reference in ["sub", ".", "", "..", "missing.mtl", "sub/%2e%2e/inner.mtl", "main.obj/x"] {
        let error = asset(&scratch).read_reference(reference).expect_err(reference);
        assert_ne!(error.fault, Fault::Limit, "{reference}: {error}");
    }
    let folder = Assets::new(&scratch.path("asset"), &[], Limits::DEFAULT)
        .read_main()
        .expect_err("a folder");
    assert_eq!(folder.fault, Fault::Unreadable);
}

#[cfg(unix)]
#[test]
fn links_out_and_special_files_give_no_byte() {
    use std::os::unix::fs::symlink;
    let scratch = layout("assets-links");
    symlink(scratch.path("secret.mtl"), scratch.path("asset/link.mtl")).expect("symlink");
    symlink(scratch.path(""), scratch.path("asset/up")).expect("symlink");
    symlink("/dev/zero", scratch.path("asset/zero.mtl")).expect("symlink");
    symlink("sub/inner.mtl", scratch.path("asset/inside.mtl")).expect("symlink");
    symlink("loop.mtl", scratch.path("asset/loop.mtl")).expect("symlink");
    for reference in ["link.mtl", "up/secret.mtl", "zero.mtl"] {
        let error = asset(&scratch).read_reference(reference).expect_err(reference);
        assert_eq!(error.fault, Fault::Forbidden, "{reference}: {error}");
    }
    assert_eq!(
        asset(&scratch).read_reference("loop.mtl").expect_err("a loop").fault,
        Fault::Unreadable
    );
    assert_eq!(asset(&scratch).read_reference("inside.mtl").expect("a link inside"), b"inner");

    let allowed = [PathBuf::from("/dev")];
    let mut with_devices = Assets::new(&scratch.path("asset/main.obj"), &allowed, Limits::DEFAULT);
    assert_eq!(
        with_devices.read_reference("zero.mtl").expect_err("a device").fault,
        Fault::Unreadable
    );
    let device = Assets::new(Path::new("/dev/zero"), &[], Limits::DEFAULT)
        .read_main()
        .expect_err("a device");
    assert_eq!(device.fault, Fault::Unreadable);

    let fifo = scratch.path("asset/fifo.mtl");
    match std::process::Command::new("mkfifo").arg(&fifo).status() {
        Ok(status) if status.success() => {
            assert_eq!(
                asset(&scratch).read_reference("fifo.mtl").expect_err("a FIFO").fault,
                Fault::Unreadable
            );
            let main = Assets::new(&fifo, &[], Limits::DEFAULT).read_main().expect_err("a FIFO");
            assert_eq!(main.fault, Fault::Unreadable);
        }
        _ => say("SKIPPED: no mkfifo here, FIFOs were not tried"),
    }
}

#[test]
fn allowed_folders_may_be_read_by_any_path() {
    let scratch = layout("assets-allowed");
    let allowed = [scratch.path("asset-other")];
    let mut assets = Assets::new(&scratch.path("asset/main.obj"), &allowed, Limits::DEFAULT);
    assert_eq!(assets.read_reference("../asset-other/near.mtl").expect("allowed"), b"near");
    let absolute = scratch.path("asset-other/near.mtl").display().to_string();
    assert_eq!(assets.read_reference(&absolute).expect("allowed"), b"near");
    assert_eq!(
        assets.read_reference("../secret.mtl").expect_err("not allowed").fault,
        Fault::Forbidden
    );
}

#[test]
fn sizes_are_limited_for_one_file_and_for_all() {
    let scratch = layout("assets-limits");
    let main = scratch.path("asset/main.obj");
    assert_eq!(
        Assets::new(&main, &[], limits(3, 100)).read_main().expect_err("4 > 3").fault,
        Fault::Limit
    );
    assert!(Assets::new(&main, &[], limits(4, 4)).read_main().is_ok());
    let mut assets = Assets::new(&main, &[], limits(100, 8));
    assets.read_main().expect("4 of 8");
    let error = assets.read_reference("sub/inner.mtl").expect_err("9 > 8");
    assert_eq!(error.fault, Fault::Limit);
    assert!(error.to_string().contains("8 bytes together"), "{error}");
}

#[test]
fn a_size_that_lies_is_not_believed() {
    let mut assets = Assets::new(Path::new("x"), &[], limits(10, 10));
    let endless = assets.read_bounded(&mut io::repeat(0), 2);
    assert_eq!(endless.expect_err("endless").fault, Fault::Limit);
    assert_eq!(assets.read_bounded(&mut &b"12345"[..], 2).expect("longer than said"), b"12345");
}

#[test]
fn standard_input_has_no_folder() {
    let mut assets = Assets::new(Path::new("-"), &[], Limits::DEFAULT);
    assert_eq!(assets.read_reference("Cargo.toml").expect_err("no folder").fault, Fault::Forbidden);
    assert_eq!(assets.main_name(), "standard input");
    assert_eq!(assets.stem(), "");
}
