//! Positions: equal bit for bit, zeros folded, numbered in order of appearance.

use lodc_fixtures::Rng;
use lodc_mesh::{PositionIds, position_key};
use std::collections::BTreeMap;

fn by_map(positions: &[[f32; 3]]) -> (Vec<u32>, Vec<u32>) {
    let (mut ids, mut first) = (BTreeMap::new(), Vec::new());
    let of_vertex = (0..positions.len())
        .map(|v| {
            *ids.entry(position_key(positions[v])).or_insert_with(|| {
                first.push(v as u32);
                first.len() as u32 - 1
            })
        })
        .collect();
    (of_vertex, first)
}

fn check(positions: &[[f32; 3]]) {
    let ids = PositionIds::new(positions);
    assert_eq!((ids.of_vertex.clone(), ids.first_vertex.clone()), by_map(positions));
    assert_eq!((ids.len(), ids.is_empty()), (ids.first_vertex.len(), positions.is_empty()));
}

#[test]
fn minus_zero_is_zero_and_nothing_else_is_folded() {
    assert_eq!(position_key([-0.0, 0.0, 1.0]), position_key([0.0, -0.0, 1.0]));
    let near = f32::from_bits(1.0f32.to_bits() + 1);
    assert_ne!(position_key([near, 0.0, 0.0]), position_key([1.0, 0.0, 0.0]));
    assert_ne!(position_key([f32::from_bits(1), 0.0, 0.0]), position_key([0.0; 3]));
    assert_ne!(position_key([-1.0, 0.0, 0.0]), position_key([1.0, 0.0, 0.0]));
}

#[test]
fn numbering_equals_a_map_on_shapes_and_random_points() {
    check(&[]);
    lodc_fixtures::ALL.iter().for_each(|(_, make)| check(make().positions()));
    let mut rng = Rng::new(9);
    for size in [1, 2, 3, 10, 1000, 5000] {
        let values = [0.0, -0.0, 1.0, -1.0, 0.1, 1e-40, 3e38];
        check(&(0..size).map(|_| std::array::from_fn(|_| rng.pick(&values))).collect::<Vec<_>>());
        check(&(0..size).map(|_| std::array::from_fn(|_| rng.unit())).collect::<Vec<_>>());
    }
}
