use super::*;
use crate::Limits;
use crate::testing::Scratch;
use std::fs::{File, metadata};
use std::path::PathBuf;

fn input(scratch: &Scratch) -> PathBuf {
    scratch.path("m.obj")
}

fn assets(scratch: &Scratch) -> Assets {
    Assets::new(&input(scratch), &[], Limits::DEFAULT)
}

fn made(scratch: &Scratch, assets: &Assets) -> MadeFrom {
    MadeFrom::of(&input(scratch), assets.files(), "o", &[]).expect("a file")
}

fn is_fresh(made: &MadeFrom, scratch: &Scratch) -> bool {
    made.unchanged(&input(scratch), &assets(scratch), "o").is_some()
}

/// Replaces a file's content and keeps its time.
fn replace(scratch: &Scratch, name: &str, bytes: &[u8]) {
    let path = scratch.path(name);
    let time = metadata(&path).and_then(|m| m.modified()).expect("a time");
    scratch.write(name, bytes);
    let file = File::options().write(true).open(path).expect("it is there");
    file.set_modified(time).expect("a time can be set");
}

#[test]
fn the_bytes_that_were_read_count_not_those_that_are_there_at_the_end() {
    let scratch = Scratch::new("made-read");
    scratch.write("m.obj", b"one");
    scratch.write("m.mtl", b"red");
    for name in ["m.obj", "m.mtl"] {
        let mut read = assets(&scratch);
        read.read_main().expect("main");
        read.read_reference("m.mtl").expect("a library");
        let before = std::fs::read(scratch.path(name)).expect("it is there");
        replace(&scratch, name, b"two");
        let made = made(&scratch, &read);
        assert!(!is_fresh(&made, &scratch), "{name} was replaced after it was read");
        replace(&scratch, name, &before);
        assert!(is_fresh(&made, &scratch), "{name} is again what was read");
    }
}

#[test]
fn a_file_that_was_two_things_in_one_run_says_nothing() {
    let scratch = Scratch::new("made-twice");
    scratch.write("m.obj", b"one");
    let (mut first, mut second) = (assets(&scratch), assets(&scratch));
    first.read_main().expect("main");
    assert!(first.read_reference("m.png").is_err());
    second.read_main().expect("main");
    let mut all = first.files().clone();
    all.extend(second.files());
    assert!(MadeFrom::of(&input(&scratch), &all, "o", &[]).is_some());
    scratch.write("m.png", b"picture");
    second.read_reference("m.png").expect("an image");
    all.extend(second.files());
    assert_eq!(MadeFrom::of(&input(&scratch), &all, "o", &[]), None);
}

#[test]
fn what_was_not_there_counts_when_it_comes_and_when_it_goes() {
    let scratch = Scratch::new("made-absent");
    scratch.write("m.obj", b"one");
    let mut read = assets(&scratch);
    read.read_main().expect("main");
    assert!(read.read_reference("m.mtl").is_err());
    let made = made(&scratch, &read);
    assert_eq!(made.files, ["m.mtl"]);
    assert!(is_fresh(&made, &scratch));
    scratch.write("m.mtl", b"");
    assert!(!is_fresh(&made, &scratch));
    std::fs::remove_file(scratch.path("m.mtl")).expect("it is there");
    assert!(is_fresh(&made, &scratch));
}

#[test]
fn a_section_comes_back_and_its_end_may_grow() {
    let made = MadeFrom {
        key: 7,
        files: vec!["a".to_owned()],
        warnings: vec!["something".to_owned()],
        program: "lodc 0.0.1".to_owned(),
    };
    assert!(!made.is_of_this_version());
    let mut bytes = made.bytes();
    assert!(MadeFrom::read(&bytes[..bytes.len() - 1]).is_err());
    bytes.push(1);
    assert_eq!(MadeFrom::read(&bytes), Ok(made));
    assert_eq!(MadeFrom::of(Path::new("-"), &RequestedFiles::default(), "", &[]), None);
}
