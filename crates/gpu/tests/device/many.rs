//! Many instances that two passes move, each compared with the reference; and a fault in any of the
//! kernels is found.

use crate::support::device;
use lodc_fixtures as fixtures;
use lodc_gpu::{Device, Session};
use lodc_lod::interactive::{Move, ResidentMany};
use lodc_mesh::{Lod, Simplified, SplitMix64};

const INSTANCES: u32 = 7;

/// The corners of triangles by the bits of their positions, the smallest corner first; sorted.
fn sorted(triangles: impl Iterator<Item = [[f32; 3]; 3]>) -> Vec<[[u32; 3]; 3]> {
    let mut all: Vec<_> = triangles
        .map(|t| {
            let mut corners = t.map(|p| p.map(f32::to_bits));
            let first = (0..3).min_by_key(|&i| corners[i]).expect("three corners");
            corners.rotate_left(first);
            corners
        })
        .collect();
    all.sort_unstable();
    all
}

/// Moves instances about, some of them at a time; the first frame and instance that is not what
/// the reference says.
fn first_wrong(
    device: &Device,
    simplified: &Simplified,
    resident: &ResidentMany,
) -> Option<(u32, u32)> {
    let collapses = simplified.collapses();
    let mut session = Session::new(device, &resident.program).expect("a small mesh");
    session.repeat(resident.repeated[0], resident.repeated[1]).expect("it is copied");
    let mut lods = vec![Lod(0); INSTANCES as usize];
    let mut random = SplitMix64::new(1);
    for frame in 0..6 {
        let mut moves = vec![];
        for (instance, lod) in (0..).zip(&mut lods) {
            let to = collapses.floor(Lod((random.unit() * collapses.records() as f32) as u32));
            // In the first frame all are where they are already.
            let to = if frame == 0 { Lod(0) } else { to };
            if frame == 0 || (instance + frame) % 3 > 0 {
                moves.push(Move { instance, from: *lod, to });
                *lod = to;
            }
        }
        let mut encoder = device.encoder();
        for (table, passes) in resident.moves(&moves) {
            session.encode_words(&mut encoder, resident.table, &table);
            session.encode_passes(&mut encoder, &passes).expect("a small mesh");
        }
        device.submit(encoder).expect("it runs");
        for (instance, &lod) in (0..).zip(&lods) {
            let truth = simplified.triangles_at(lod);
            let positions = simplified.mesh().positions();
            let truth = sorted(truth.iter().map(|t| t.corners.map(|v| positions[v as usize])));
            let drawn = resident.drawn(instance as usize);
            let drawn = session.drawn_triangles(&drawn).expect("it is read");
            if sorted(drawn.into_iter()) != truth {
                return Some((frame, instance));
            }
        }
    }
    None
}

fn meshes() -> impl Iterator<Item = Simplified> {
    ["machine_part", "cube"]
        .into_iter()
        .map(|name| fixtures::named(name).expect("a named shape"))
        .chain((0..8).map(fixtures::random))
        .filter(|mesh| mesh.vertex_count() > 1)
        .map(|mesh| fixtures::random_collapse(&mesh, 1))
}

#[test]
fn every_instance_is_at_its_own_level() {
    let Some(device) = device() else { return };
    for (number, simplified) in meshes().enumerate() {
        let resident = ResidentMany::new(&simplified, INSTANCES).expect("a small mesh");
        assert_eq!(first_wrong(&device, &simplified, &resident), None, "mesh {number}");
    }
}

/// A kernel, a piece of it, and something else in its place.
const FAULTS: &[(&str, &str, &str)] = &[
    ("extract_many", "i >= p.threads", "i + 1u >= p.threads"),
    ("extract_many", "moves[middle].x <= thread", "moves[middle].x < thread"),
    ("extract_many", "own.y * p.vertices + v", "own.y * p.vertices"),
    ("extract_many", "entries[at] < own.z", "entries[at] + 1u < own.z"),
    ("extract_many", "while (at > first && entries[at - 1u] >= own.z) { at--; }", ""),
    ("extract_many", "current[at_instance] = at - first;", ""),
    ("extract_many", "to_record + word", "from_record + word"),
    ("live_many", "i >= p.moves * p.submeshes", "i + 1u >= p.moves * p.submeshes"),
    ("live_many", "moves[i / p.submeshes].y", "moves[0].y"),
    ("live_many", "let base = instance * p.vertices", "let base = 0u * p.vertices"),
    ("live_many", "3u * (low - first)", "3u * ((low - first) / 2u)"),
    ("live_many", "3u * first;", "first;"),
    ("live_many", "same(b, c) ||", ""),
];

#[test]
fn a_fault_in_the_kernels_of_many_is_found() {
    let Some(device) = device() else { return };
    for &(kernel, right, wrong) in FAULTS {
        let found = meshes().any(|simplified| {
            let mut resident = ResidentMany::new(&simplified, INSTANCES).expect("a small mesh");
            for k in resident.program.kernels.iter_mut().filter(|k| k.name == kernel) {
                assert!(k.wgsl.contains(right), "{kernel} has no {right:?}");
                k.wgsl = k.wgsl.replacen(right, wrong, 1);
            }
            first_wrong(&device, &simplified, &resident).is_some()
        });
        assert!(found, "nobody sees {wrong:?} in {kernel}");
    }
}
