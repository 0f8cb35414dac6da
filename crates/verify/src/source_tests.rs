//! Differences that must be found, and those that must be accepted.

use super::source_difference;
use lodc_fixtures::{ALL, random_collapse};
use lodc_mesh::{Mesh, MeshParts};

fn shape(name: &str) -> Mesh {
    ALL.iter().find(|(n, _)| *n == name).map(|(_, make)| make()).expect("a named shape")
}

fn changed(mesh: &Mesh, change: impl FnOnce(&mut MeshParts)) -> Mesh {
    let mut parts = mesh.clone().into_parts();
    change(&mut parts);
    Mesh::try_from(parts).expect("still a mesh")
}

#[test]
fn every_shape_is_found_again_in_its_collapse_order() {
    for (name, make) in ALL {
        let mesh = make();
        let simplified = random_collapse(&mesh, 7);
        assert_eq!(source_difference(&mesh, simplified.mesh()), None, "{name}");
    }
}

#[test]
fn a_flipped_triangle_is_seen_and_a_rotated_one_is_not() {
    let mesh = shape("cube");
    assert_eq!(source_difference(&mesh, &changed(&mesh, |p| p.triangles[3].rotate_left(1))), None);
    assert!(source_difference(&mesh, &changed(&mesh, |p| p.triangles[3].swap(0, 1))).is_some());
}

#[test]
fn the_last_bit_of_a_position_or_an_attribute_is_seen() {
    let mesh = shape("cube");
    let moved = changed(&mesh, |p| p.positions[5][1] = p.positions[5][1].next_up());
    assert!(source_difference(&mesh, &moved).is_some_and(|what| what.contains("only in the")));
    let bent = changed(&mesh, |p| p.attributes[0].bytes[4] ^= 1);
    assert!(source_difference(&mesh, &bent).is_some());
}

#[test]
fn a_doubled_triangle_in_place_of_another_is_seen() {
    let mesh = shape("cube");
    assert!(
        source_difference(&mesh, &changed(&mesh, |p| p.triangles[1] = p.triangles[0])).is_some()
    );
}
