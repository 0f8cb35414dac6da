use super::*;

// The documents of the other golden files were made up: no glTF can be written of them.
const FILES: [&str; 1] = ["triangle"];

fn golden(name: &str) -> Vec<u8> {
    let path = format!("{}/../../fixtures/golden/v1/{name}", env!("CARGO_MANIFEST_DIR"));
    std::fs::read(&path).unwrap_or_else(|e| panic!("{path}: {e}"))
}

fn fed(session: &mut Session, bytes: &[u8]) -> Status {
    session.input(bytes.len()).copy_from_slice(bytes);
    session.feed()
}

fn text(session: &Session) -> String {
    String::from_utf8(session.output().to_vec()).expect("text")
}

#[test]
fn a_file_becomes_a_glb_with_levels() {
    for name in FILES {
        let file = golden(&format!("{name}.lodc"));
        let mut session = Session::default();
        session.input(file.len()).copy_from_slice(&file);
        assert_eq!(session.open(), Status::Done, "{name}: {}", text(&session));
        assert!(session.output().starts_with(b"glTF"), "{name}");
        let has = |word: &[u8]| session.output().windows(word.len()).any(|w| w == word);
        assert!(has(b"\"removals\"") && has(b"\"targets\""), "{name} has no levels");
    }
}

#[test]
fn a_file_of_the_gpu_layout_becomes_the_same_glb() {
    let [packed, wide] = ["two_parts", "two_parts_gpu"].map(|name| {
        let file = golden(&format!("{name}.lodc"));
        let mut session = Session::default();
        session.input(file.len()).copy_from_slice(&file);
        assert_eq!(session.open(), Status::Done, "{name}: {}", text(&session));
        session.output().to_vec()
    });
    assert!(packed.starts_with(b"glTF") && packed == wide);
}

#[test]
fn a_stream_grows_with_its_bytes_and_ends_complete() {
    // The last two have vertices of hundreds of triangles.
    for name in FILES.iter().chain(&["book", "flaps"]) {
        let stream = golden(&format!("{name}.lods"));
        let mut session = Session::default();
        assert_eq!((session.mesh(), session.output()), (Status::Done, &[][..]), "nothing yet");
        let mut largest = 0;
        for piece in stream.chunks(57) {
            assert_eq!(fed(&mut session, piece), Status::Done, "{name}: {}", text(&session));
            assert_eq!(session.mesh(), Status::Done, "{name}: {}", text(&session));
            largest = largest.max(session.output().len());
        }
        assert_eq!(session.output().len(), largest, "{name}: the last mesh is the largest");
        assert!(session.output().starts_with(b"glTF"), "{name}");
        assert_eq!(fed(&mut session, &[]), Status::Done);
        assert!(text(&session).starts_with("{\"complete\":true"), "{}", text(&session));
    }
}

#[test]
fn damage_is_stated_in_a_line_and_harms_no_other_session() {
    let mut sessions = Sessions::new();
    let (a, b) = (sessions.open(), sessions.open());
    assert_eq!((a, b), (0, 1));
    let session = sessions.get(a).expect("open");
    session.input(4).copy_from_slice(b"junk");
    assert_eq!(session.open(), Status::Failed);
    assert!(!text(session).is_empty() && !text(session).contains('\n'));
    assert_eq!(fed(session, b"junk, too"), Status::Failed);
    let stream = golden("triangle.lods");
    assert_eq!(fed(sessions.get(b).expect("open"), &stream), Status::Done);
    sessions.close(a);
    assert!(sessions.get(a).is_none() && sessions.get(7).is_none());
    assert_eq!(sessions.open(), a, "the number is free again");
}
