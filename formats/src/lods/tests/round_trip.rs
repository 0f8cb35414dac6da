//! A mesh out of a stream goes into another one and comes back as it was.

use super::*;
use crate::lods::as_streamed;
use lodc_fixtures as fixtures;

/// The objects of a complete stream as a file again.
fn unpacked(bytes: &[u8]) -> LodFile {
    let unpacker = fed(bytes);
    let object = |i: usize| LodObject {
        info: unpacker.info(i).clone(),
        simplified: Arc::new(unpacker.rebuilt(i).expect("a sound stream").simplified),
        models: Vec::new(),
    };
    LodFile {
        source: unpacker.source().expect("a text").clone(),
        document: unpacker.document().expect("a document").clone(),
        ..obj((0..unpacker.objects()).map(object).collect())
    }
}

fn packed(file: &LodFile) -> Vec<u8> {
    pack(file, &PackOptions::default()).expect("a sound file").bytes
}

fn assert_same(a: &Simplified, b: &Simplified, case: &str) {
    let [p, q] = [a, b].map(|s| s.mesh().clone().into_parts());
    assert!(p.positions == q.positions && p.triangles == q.triangles, "{case}: the mesh");
    assert!(p.attributes == q.attributes && p.vertex_submesh == q.vertex_submesh, "{case}: values");
    let [p, q] = [a, b].map(|s| s.collapses().parts());
    assert!(p.targets == q.targets && p.step_ends == q.step_ends, "{case}: the sequence");
    assert_eq!(p.step_triangles, q.step_triangles, "{case}");
    assert_eq!(
        (p.last_legal_lod, p.first_topology_change),
        (q.last_legal_lod, q.first_topology_change),
        "{case}"
    );
}

#[test]
fn packing_unpacking_and_packing_is_a_fixed_point() {
    for (name, make) in fixtures::ALL {
        let mesh = make();
        let by_quadric =
            lodc_simplify::simplify(&mesh, &lodc_simplify::Options::DEFAULT, &|_, _| {});
        for (by, simplified) in
            [("quadric", by_quadric), ("chance", fixtures::random_collapse(&mesh, 1))]
        {
            let case = format!("{name} by {by}");
            let once = unpacked(&packed(&gltf(vec![object(name, simplified.clone())])));
            let bytes = packed(&once);
            let twice = unpacked(&bytes);
            assert_same(&once.objects[0].simplified, &twice.objects[0].simplified, &case);
            assert!(packed(&twice) == bytes, "{case}: other bytes");
            // What a build makes at once.
            let streamed = as_streamed(&simplified, StepOrder::Batches).expect("a sound mesh");
            assert_same(&streamed, &once.objects[0].simplified, &case);
        }
    }
}
