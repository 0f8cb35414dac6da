use super::*;
use crate::Select;

const PART: &str = "../../fixtures/machine_part.glb";

#[test]
fn a_file_is_the_same_whatever_it_comes_from() {
    let by_path = crate::build(PART).run().expect("a fixture").to_bytes();
    let bytes = std::fs::read(PART).expect("a fixture");
    assert_eq!(crate::build(&bytes).run().expect("a mesh").to_bytes(), by_path);
    let reader = Source::reader(bytes.as_slice());
    assert_eq!(crate::build(reader).run().expect("a mesh").to_bytes(), by_path);
    assert_eq!(crate::open(by_path.clone()).expect("a file").to_bytes(), by_path);
    let reader = Source::reader(by_path.as_slice());
    assert_eq!(crate::open(reader).expect("a file").to_bytes(), by_path);
}

#[test]
fn wrong_sources_are_errors_that_name_no_file() {
    let said = |result: Result<crate::File, crate::Error>| {
        result.map(|file| file.triangles()).expect_err("it is wrong").to_string()
    };
    assert!(said(crate::open(b"junk")).contains("not a .lodc file"));
    assert!(!said(crate::build(b"junk").run()).contains("standard input"));
    let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let arrays = |last: u32| Source::arrays(positions.clone(), [[0, 1, last]], Vec::new());
    assert!(said(crate::open(arrays(2))).contains("lodc::build"));
    assert!(said(crate::build(arrays(3)).run()).contains("triangle 0"));
    let short = Attribute::of_floats(lodc_mesh::Semantic::Normal, &[[0.0f32; 3]; 2]);
    let source = Source::arrays(positions.clone(), [[0, 1, 2]], vec![short]);
    assert!(said(crate::build(source).run()).contains("attribute"));
    let mut infinite = positions.clone();
    infinite[1][0] = f32::INFINITY;
    assert!(
        said(crate::build(Source::arrays(infinite, [[0, 1, 2]], Vec::new())).run())
            .contains("not a finite number")
    );
    let with_degenerate = Source::arrays(positions, [[0, 1, 2], [0, 0, 2]], Vec::new());
    assert_eq!(crate::build(with_degenerate).run().expect("a mesh").triangles(), 1);
}

#[test]
fn objects_of_a_level_have_their_materials() {
    let file = crate::build(PART).run().expect("a fixture");
    let level = file.level(Select::Ratio(0.5)).expect("a level");
    for object in level.objects() {
        let submeshes = object.mesh().submeshes().len();
        assert_eq!(object.materials().len(), submeshes);
        assert!(object.materials().all(|m| m.is_some_and(|m| m.name.starts_with("material"))));
    }
}
