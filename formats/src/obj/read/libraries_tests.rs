use super::*;

fn parse(source: &[u8]) -> Materials {
    let mut materials = Materials::default();
    materials.parse("a.mtl", source).expect("small");
    materials
}

#[test]
fn lines_are_kept_as_they_are_and_not_understood() {
    let m = parse(
        b"# by hand\nnewmtl  a name, with spaces \r\n\
        Kd 0.5\r\n  map_Kd -s 1 1 1 c:\\x y.png\n\n# no\nnonsense\nnewmtl b",
    );
    let lines = ["Kd 0.5", "map_Kd -s 1 1 1 c:\\x y.png", "nonsense"].map(str::to_owned).to_vec();
    let expected = [
        ObjMaterial { name: "a name, with spaces".to_owned(), lines },
        ObjMaterial { name: "b".to_owned(), lines: Vec::new() },
    ];
    assert_eq!(m.list, expected);
    assert!(m.warnings.is_empty());
}

#[test]
fn the_first_definition_holds_and_strays_are_counted() {
    let m = parse(b"Kd 1 1 1\nnewmtl a\nKd 1\nnewmtl a\nKd 2\nNs 3\nnewmtl b\nKd 3\n");
    let found: Vec<_> = m.list.iter().map(|m| (m.name.as_str(), m.lines.join(";"))).collect();
    assert_eq!(found, [("a", "Kd 1".to_owned()), ("b", "Kd 3".to_owned())]);
    assert_eq!(m.warnings.len(), 2);
    assert!(m.warnings[0].contains("1 material is defined more than once"), "{:?}", m.warnings);
    assert!(m.warnings[1].contains("skipped 1 line before"), "{:?}", m.warnings);
}

#[test]
fn continued_lines_and_other_encodings_are_read() {
    let m = parse(b"\xef\xbb\xbfnewmtl caf\xe9\rKd 1 \\\n0 0\n\\");
    assert_eq!(m.list[0].name, "café");
    assert_eq!(m.list[0].lines, ["Kd 1  0 0"]);
}

#[test]
fn a_library_of_absurd_size_is_a_limit() {
    let error =
        Materials::default().parse("a.mtl", &vec![b'\n'; MAX_BYTES + 1]).expect_err("too large");
    assert_eq!((error.fault, error.file.as_str()), (Fault::Limit, "a.mtl"));
}

#[test]
fn damaged_libraries_give_materials_without_line_ends_or_a_limit() {
    use super::super::tests::{SEED_MTL, mutated};
    let mut random = crate::testing::Random(77);
    let mut sizes = [0; 8];
    for round in 0..20_000 {
        let source = mutated(SEED_MTL, &mut random);
        let m = parse(&source);
        for material in &m.list {
            let texts = material.lines.iter().chain([&material.name]);
            assert!(
                texts.clone().all(|t| !t.contains(['\n', '\r'])),
                "round {round}: {material:?}"
            );
            let kept: usize = texts.map(String::len).sum();
            // A byte that is no UTF-8 becomes a character of three.
            assert!(
                kept <= 3 * source.len() + 8,
                "round {round}: {kept} bytes of {}",
                source.len()
            );
        }
        sizes[m.list.len().min(7)] += 1;
    }
    assert!(sizes[1..4].iter().all(|&n| n > 100), "one-sided: {sizes:?}");
}
