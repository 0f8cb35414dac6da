//! What CI systems read: JUnit files and annotations.

use crate::support::{Folder, grid};

#[test]
fn failures_of_verify_are_annotations_and_junit_cases() {
    let f = Folder::new();
    f.file("a.obj", grid(4));
    f.file("b.obj", grid(5));
    f.lodc(["build", "a.obj", "b.obj", "-o", "out/", "-q"]).ends(0);
    f.file("out/bad,1.lodc", "nothing");
    let args = ["verify", "out", "--junit", "v.xml", "--annotate", "github", "-q"];
    let run = f.lodc(args).ends(3);
    let notes: Vec<&str> = run.err.lines().filter(|l| l.starts_with("::error ")).collect();
    assert_eq!(notes.len(), 1, "{}", run.err);
    assert!(notes[0].starts_with("::error file=out/bad%2C1.lodc,title=lodc verify::read: "));
    let xml = String::from_utf8(f.read("v.xml")).expect("text");
    assert!(
        xml.contains("<testsuite name=\"out/a.obj.lodc\"") && xml.contains("errors=\"1\""),
        "{xml}"
    );
    let run =
        f.lodc(["verify", "out/a.obj.lodc", "--source", "b.obj", "--annotate", "github"]).ends(1);
    assert!(
        run.err.contains("::error file=out/a.obj.lodc,title=lodc verify::file: source"),
        "{}",
        run.err
    );
    f.lodc(["verify", "out/a.obj.lodc", "--annotate", "other"]).ends(2);
}
