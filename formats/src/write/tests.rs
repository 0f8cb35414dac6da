pub(super) mod faults;

use super::*;
use crate::testing::Scratch;

fn output(path: PathBuf, bytes: &[u8]) -> OutputFile {
    OutputFile { path, bytes: bytes.to_vec() }
}

fn names(scratch: &Scratch) -> Vec<String> {
    let entries = fs::read_dir(scratch.path("")).expect("the folder");
    let mut names: Vec<_> = entries
        .map(|e| e.expect("an entry").file_name().into_string().expect("our names"))
        .collect();
    names.sort();
    names
}

fn read(scratch: &Scratch, name: &str) -> Vec<u8> {
    fs::read(scratch.path(name)).expect(name)
}

fn prefix(name: &str) -> String {
    format!(".lodc-{:016x}-", xxh3_64(name.as_bytes()))
}

#[test]
fn files_are_written_and_replaced_and_nothing_else_is_left() {
    let scratch = Scratch::new("write-plain");
    for bytes in [&b"first"[..], b"second", b""] {
        write_all(&[output(scratch.path("a.gltf"), bytes), output(scratch.path("a.bin"), b"bin")])
            .expect("written");
        assert_eq!(read(&scratch, "a.gltf"), bytes);
        assert_eq!(names(&scratch), ["a.bin", "a.gltf"]);
    }
}

#[test]
fn a_failure_leaves_the_old_files() {
    let scratch = Scratch::new("write-fail");
    scratch.write("a.gltf", b"old");
    scratch.write("a.bin/file", b"in the way");
    let error =
        write_all(&[output(scratch.path("a.gltf"), b"new"), output(scratch.path("a.bin"), b"new")]);
    let error = error.expect_err("a folder is in the way");
    assert_eq!(error.fault, Fault::NotWritten);
    assert!(error.file.ends_with("a.bin"), "{error}");
    assert_eq!(read(&scratch, "a.gltf"), b"old");
    assert_eq!(names(&scratch), ["a.bin", "a.gltf"]);
    let missing =
        write_all(&[output(scratch.path("no/such/folder/x"), b"x")]).expect_err("no folder");
    assert_eq!(missing.fault, Fault::NotWritten);
}

#[test]
fn a_rename_that_fails_takes_the_earlier_ones_back() {
    let scratch = Scratch::new("write-undo");
    scratch.write("a.bin", b"old");
    let write = |name: &str| {
        Pending::write(&output(scratch.path(name), b"new")).expect("written").expect("not a device")
    };
    let (mut replaced, mut added, mut failing) = (write("a.bin"), write("b.bin"), write("a.gltf"));
    replaced.commit(true).expect("renamed");
    added.commit(true).expect("renamed");
    assert_eq!(
        (read(&scratch, "a.bin"), read(&scratch, "b.bin")),
        (b"new".to_vec(), b"new".to_vec())
    );
    fs::create_dir(scratch.path("a.gltf")).expect("a folder in the way, made at the last moment");
    failing.commit(true).expect_err("a folder is in the way");
    added.undo();
    replaced.undo();
    drop(failing);
    assert_eq!(read(&scratch, "a.bin"), b"old");
    assert_eq!(names(&scratch), ["a.bin", "a.gltf"]);
}

#[test]
fn what_a_killed_run_left_is_removed_and_what_lives_stays() {
    let scratch = Scratch::new("write-stale");
    let dead = format!("{}4000000-0.tmp", prefix("a.lodc"));
    let dead_old = format!("{}4000000-1.old", prefix("a.lodc"));
    let other_target = format!("{}4000000-0.tmp", prefix("b.lodc"));
    let lookalike = format!("{}notes.tmp", prefix("a.lodc"));
    for name in [&dead, &dead_old, &other_target, &lookalike] {
        scratch.write(name, b"left");
    }
    let live = Temporary::create(&scratch.path(""), &prefix("a.lodc")).expect("created");
    write_all(&[output(scratch.path("a.lodc"), b"new")]).expect("written");
    let left = names(&scratch);
    assert!(live.path.exists(), "another writer's file was removed");
    assert!(!left.contains(&dead) && !left.contains(&dead_old), "{left:?}");
    assert!(left.contains(&other_target) && left.contains(&lookalike), "{left:?}");
    drop(live);
    assert_eq!(names(&scratch).len(), 3);
}

#[test]
fn writers_of_one_target_do_not_disturb_each_other() {
    let scratch = Scratch::new("write-race");
    let target = scratch.path("a.lodc");
    thread::scope(|scope| {
        for writer in 0..4u8 {
            let target = &target;
            scope.spawn(move || {
                for _ in 0..50 {
                    write_all(&[output(target.clone(), &[writer; 5000])]).expect("written");
                }
            });
        }
    });
    let bytes = read(&scratch, "a.lodc");
    assert!(bytes.len() == 5000 && bytes.iter().all(|&b| b == bytes[0]), "a mixture");
    assert_eq!(names(&scratch), ["a.lodc"]);
}

#[cfg(unix)]
#[test]
fn links_are_followed_devices_written_directly_and_modes_kept() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let scratch = Scratch::new("write-kinds");
    scratch.write("store/real.lodc", b"old");
    let real = scratch.path("store/real.lodc");
    fs::set_permissions(&real, fs::Permissions::from_mode(0o640)).expect("mode");
    symlink("store/real.lodc", scratch.path("link.lodc")).expect("link");
    write_all(&[output(scratch.path("link.lodc"), b"new")]).expect("written");
    assert_eq!(fs::read(&real).expect("there"), b"new");
    assert!(scratch.path("link.lodc").is_symlink());
    assert_eq!(fs::metadata(&real).expect("there").permissions().mode() & 0o777, 0o640);
    write_all(&[output(PathBuf::from("/dev/null"), b"new")]).expect("swallowed");
    assert!(!fs::metadata("/dev/null").expect("there").is_file());
}

#[test]
fn a_long_name_is_no_obstacle() {
    let scratch = Scratch::new("write-long");
    let name = format!("{}.lodc", "x".repeat(250));
    write_all(&[output(scratch.path(&name), b"new")]).expect("written");
    assert_eq!(names(&scratch), [name]);
}
