//! Wedge groups: against known shapes, and against the definition followed word by word.

use lodc_fixtures as fixtures;
use lodc_mesh::{Mesh, PositionIds, WedgeGroups};

fn groups(mesh: &Mesh) -> (PositionIds, WedgeGroups) {
    let positions = mesh.position_ids();
    let groups = WedgeGroups::new(mesh, &positions);
    (positions, groups)
}

/// The definition: at one position, two corners are joined if their triangles share an edge there;
/// corners of one vertex are joined; and so on until nothing changes.
fn by_definition(mesh: &Mesh, positions: &PositionIds) -> Vec<u32> {
    let position = |v: u32| positions.of_vertex[v as usize];
    let mut name: Vec<u32> = (0..mesh.vertex_count() as u32).collect();
    loop {
        let before = name.clone();
        for s in mesh.triangles() {
            for t in mesh.triangles() {
                for &v in s {
                    for &w in t {
                        let other = |&x: &u32| {
                            position(x) != position(v)
                                && t.iter().any(|&y| position(x) == position(y))
                        };
                        if position(v) == position(w) && s.iter().any(other) {
                            let least = name[v as usize].min(name[w as usize]);
                            (name[v as usize], name[w as usize]) = (least, least);
                        }
                    }
                }
            }
        }
        if name == before {
            return name;
        }
    }
}

fn check(what: &str, mesh: &Mesh) {
    let (positions, groups) = groups(mesh);
    let wanted = by_definition(mesh, &positions);
    let found: Vec<u32> =
        groups.of_vertex.iter().map(|&g| groups.first_vertex[g as usize]).collect();
    assert_eq!(found, wanted, "{what}");
    assert!(groups.first_vertex.is_sorted(), "{what}: groups are numbered by their first vertex");
    assert_eq!(
        groups.len(),
        groups.of_vertex.iter().max().map_or(0, |&m| m as usize + 1),
        "{what}"
    );
    assert_eq!(groups.is_empty(), mesh.vertex_count() == 0);
}

#[test]
fn groups_follow_the_definition_on_small_shapes() {
    for (name, make) in fixtures::ALL {
        let mesh = make();
        if mesh.triangles().len() <= 160 {
            check(name, &mesh);
        }
    }
}

#[test]
fn groups_follow_the_definition_on_random_meshes() {
    let mut checked = 0;
    for seed in 0..150 {
        let mesh = fixtures::random(seed);
        if mesh.triangles().len() <= 120 {
            check(&format!("random mesh {seed}"), &mesh);
            checked += 1;
        }
    }
    assert!(checked > 40, "{checked}");
}

fn counts(mesh: &Mesh) -> (usize, usize, usize) {
    let (positions, groups) = groups(mesh);
    (mesh.vertex_count(), positions.len(), groups.len())
}

#[test]
fn seams_and_hard_edges_do_not_divide_a_group() {
    assert_eq!(counts(&fixtures::cube()), (24, 8, 8));
    assert_eq!(counts(&fixtures::uv_sphere(16, 8)), (151, 114, 114));
    assert_eq!(counts(&fixtures::faceted_sphere()), (960, 162, 162));
    assert_eq!(counts(&fixtures::unwelded_sphere()), (960, 162, 162));
    let (_, positions, groups) = counts(&fixtures::machine_part());
    assert_eq!(positions, groups, "submeshes that share a border are one topology");
}

#[test]
fn what_touches_in_a_point_stays_apart_unless_a_vertex_is_shared() {
    assert_eq!(counts(&fixtures::bow_tie()), (12, 11, 12));
    assert_eq!(counts(&fixtures::bow_tie_shared()), (11, 11, 11));
    let (_, positions, groups) = counts(&fixtures::touching_spheres());
    assert_eq!(groups, positions + 1);
}

#[test]
fn a_half_twist_makes_no_difference() {
    let (vertices, positions, groups) = counts(&fixtures::mobius_strip());
    assert_eq!((positions, groups), (vertices, vertices));
}

#[test]
fn zeros_of_both_signs_are_one_place() {
    assert_eq!(counts(&fixtures::signed_zero_ring()), (12, 5, 5));
}

#[test]
fn all_leaves_on_an_edge_are_one_group_at_its_ends() {
    // As a soup every leaf has its own vertices; the edge they share by position joins them.
    let mut parts = fixtures::non_manifold_fan().into_parts();
    let corners: Vec<u32> = parts.triangles.as_flattened().to_vec();
    parts.positions = corners.iter().map(|&v| parts.positions[v as usize]).collect();
    parts.vertex_submesh = vec![0; corners.len()];
    parts.triangles =
        (0..corners.len() as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    assert_eq!(counts(&Mesh::try_from(parts).expect("a soup is a mesh")), (30, 12, 12));
}

#[test]
fn vertices_without_triangles_are_groups_of_their_own() {
    let mesh = Mesh::try_from(crate::parts(&[[0.0; 3], [0.0; 3], [1.0; 3]], &[]))
        .expect("points are a mesh");
    assert_eq!(counts(&mesh), (3, 2, 3));
}
