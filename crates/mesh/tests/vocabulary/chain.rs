//! Chains: every level is what the reference says, over a prefix of the vertices.

use lodc_fixtures::{random, random_collapse};
use lodc_mesh::{Lod, OrientedTriangle, Simplified, TriangleHash};
use std::collections::BTreeSet;

fn lods(s: &Simplified) -> Vec<Lod> {
    let last = s.collapses().last().0;
    [0, last / 3, last / 2, last * 3 / 4, last].map(|l| s.collapses().floor(Lod(l))).to_vec()
}

/// Oriented triangles by the positions of their corners: vertices have other numbers in a chain.
fn key(positions: &[[f32; 3]], t: OrientedTriangle) -> (u32, [[u32; 3]; 3]) {
    let corners = t.corners.map(|v| positions[v as usize].map(f32::to_bits));
    let least = (0..3).min_by_key(|&k| corners[k]).unwrap_or(0);
    (t.submesh, std::array::from_fn(|k| corners[(least + k) % 3]))
}

#[test]
fn every_level_of_a_chain_is_the_reference() {
    for seed in 0..60 {
        let s = random_collapse(&random(seed), seed);
        let chain = s.chain(&lods(&s)).expect("levels of the sequence");
        for (lod, level) in lods(&s).into_iter().zip(&chain.levels) {
            let truth = s.triangles_at(lod);
            let of_chain = level.iter().zip(0..).flat_map(|(triangles, submesh)| {
                triangles.iter().map(move |&t| OrientedTriangle::new(submesh, t))
            });
            let mut shown: Vec<_> = of_chain.map(|t| key(chain.mesh.positions(), t)).collect();
            let mut wanted: Vec<_> =
                truth.into_iter().map(|t| key(s.mesh().positions(), t)).collect();
            shown.sort_unstable();
            wanted.sort_unstable();
            assert_eq!(shown, wanted, "seed {seed}, LOD {}", lod.0);
        }
    }
}

#[test]
fn coarser_levels_use_prefixes() {
    for seed in 0..60 {
        let s = random_collapse(&random(seed), seed);
        let chain = s.chain(&lods(&s)).expect("levels of the sequence");
        for (level, &prefix) in chain.levels.iter().zip(&chain.prefixes) {
            let within = level.iter().flatten().flatten().all(|&v| v < prefix);
            assert!(within, "seed {seed}: {prefix}");
        }
        for (k, &prefix) in chain.prefixes.iter().enumerate() {
            let used: BTreeSet<u32> =
                chain.levels[k..].iter().flatten().flatten().flatten().copied().collect();
            assert_eq!(prefix as usize, used.len(), "seed {seed}, level {k} and coarser ones");
        }
        let prefixes = &chain.prefixes;
        assert!(prefixes.is_sorted_by(|a, b| a >= b), "seed {seed}: {prefixes:?}");
        assert_eq!(prefixes[0] as usize, chain.mesh.vertex_count(), "seed {seed}");
        let of = |triangles: &mut dyn Iterator<Item = [u32; 3]>| -> TriangleHash {
            triangles.map(|t| OrientedTriangle::new(0, t)).collect()
        };
        let finest = of(&mut chain.mesh.triangles().iter().copied());
        assert_eq!(finest, of(&mut chain.levels[0].iter().flatten().copied()), "seed {seed}");
    }
}

#[test]
fn levels_become_the_next_by_index() {
    for seed in 0..60 {
        let s = random_collapse(&random(seed), seed);
        let geomorph = s.morphing_chain(&lods(&s)).expect("levels of the sequence");
        let (chain, becomes) = (&geomorph.chain, &geomorph.becomes);
        let next = geomorph.next();
        for (v, &to) in becomes.iter().enumerate() {
            assert_eq!(next.positions()[v], chain.mesh.positions()[to as usize], "seed {seed}");
        }
        for (k, pair) in chain.levels.windows(2).enumerate() {
            let prefix = chain.prefixes[k + 1];
            let to = |v: u32| if v < prefix { v } else { becomes[v as usize] };
            let position = |v: u32| chain.mesh.positions()[v as usize].map(|x| (x + 0.0).to_bits());
            let has_area = |t: &[u32; 3]| {
                let [a, b, c] = t.map(position);
                a != b && b != c && c != a
            };
            for (now, next) in pair[0].iter().zip(&pair[1]) {
                let mut arrived: Vec<_> =
                    now.iter().map(|t| t.map(to)).filter(has_area).map(turned).collect();
                let mut wanted: Vec<_> = next.iter().copied().map(turned).collect();
                arrived.sort_unstable();
                wanted.sort_unstable();
                assert_eq!(arrived, wanted, "seed {seed}, level {k}");
            }
        }
    }
}

/// A triangle from its least corner on.
fn turned(t: [u32; 3]) -> [u32; 3] {
    let least = (0..3).min_by_key(|&k| t[k]).unwrap_or(0);
    std::array::from_fn(|k| t[(least + k) % 3])
}
