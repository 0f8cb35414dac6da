//! Quantisation errors stay within their bounds.

use super::super::Quantize;
use super::*;
use lodc_fixtures as fixtures;
use lodc_mesh::{Component, Semantic};

#[test]
fn numbers_move_no_farther_than_the_bound() {
    for name in ["uv_sphere", "terrain", "machine_part", "torus", "needles", "skinned_tube_u8"] {
        let simplified = fixtures::random_collapse(&fixtures::named(name).expect("a shape"), 5);
        let file = obj(vec![object(name, simplified)]);
        for bits in [4, 10, 16] {
            let quantize = Quantize { position: Some(bits), normal: Some(bits), uv: Some(bits) };
            let packed = pack(&file, &PackOptions { quantize, ..PackOptions::default() })
                .expect("a sound file");
            let unpacker = fed(&packed.bytes);
            assert!(unpacker.is_complete());
            let ordered = in_stream_order(&file);
            let mesh = ordered.objects[0].simplified.mesh();
            let decoded = unpacker.mesh_parts(0);
            let bound = |stream: &str| packed.objects[0].bounds.iter().find(|b| b.stream == stream);
            let position = bound("position").expect("positions were quantised");
            for (a, b) in mesh.positions().iter().zip(&decoded.positions) {
                for c in 0..3 {
                    let moved = (f64::from(a[c]) - f64::from(b[c])).abs();
                    assert!(
                        moved <= position.coordinate,
                        "{name}, {bits} bits: {moved} for {}",
                        position.coordinate
                    );
                }
            }
            for (i, a) in mesh.attributes().iter().enumerate() {
                let name = match a.semantic {
                    Semantic::Normal => "normal",
                    Semantic::TexCoord(0) => "uv 0",
                    _ => "",
                };
                let bound = bound(name)
                    .filter(|_| a.component == Component::F32)
                    .map_or(0.0, |b| b.coordinate);
                for v in 0..mesh.vertex_count() as u32 {
                    for c in 0..usize::from(a.components) {
                        let moved = (a.value(v, c) - decoded.attributes[i].value(v, c)).abs();
                        assert!(
                            f64::from(moved) <= bound,
                            "{name}, {bits} bits: {moved} for {bound}"
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn triangles_that_quantising_flattens_are_counted() {
    let file = obj(vec![object("sphere", fixtures::random_collapse(&fixtures::icosphere(3), 1))]);
    let quantize = Quantize { position: Some(3), ..Quantize::default() };
    let packed =
        pack(&file, &PackOptions { quantize, ..PackOptions::default() }).expect("a sound file");
    let (mesh, cleaning) = fed(&packed.bytes).mesh(0).expect("a mesh");
    assert!(cleaning.degenerate_triangles > 0);
    assert_eq!(mesh.triangles().len() + cleaning.degenerate_triangles, 1280);
}
