//! Verification passes what is right and names what is wrong.

use super::*;
use lodc_fixtures as fixtures;
use lodc_lod::{AnyModel, Interactive, ModelKind};
use lodc_mesh::Simplified;
use lodc_model::{Array, Layout, StorageCost, Traffic};
use lodc_strip::{StripOptions, StripPool};
use std::sync::Arc;

pub(super) fn sphere() -> Simplified {
    fixtures::random_collapse(&fixtures::uv_sphere(12, 8), 5)
}

pub(super) fn verify_all(simplified: &Simplified) -> Vec<Check> {
    let simplified = Arc::new(simplified.clone());
    let reference = Reference::new(&simplified).expect("a sequence of ordinary length");
    let mut checks = reference.checks().to_vec();
    let model = AnyModel::build(
        ModelKind::Interactive,
        &mut StripPool::new(&simplified, StripOptions::default()),
    )
    .expect("triangles are in order");
    checks.extend(verify(&model, &reference, &VerifyOptions::default()));
    checks
}

#[test]
fn nothing_is_wrong_with_any_fixture() {
    let mut meshes: Vec<(String, lodc_mesh::Mesh)> =
        fixtures::ALL.iter().map(|&(name, make)| (name.to_owned(), make())).collect();
    meshes.retain(|(_, mesh)| mesh.triangles().len() <= 400);
    meshes.extend((100..200).map(|seed| (format!("random {seed}"), fixtures::random(seed))));
    for (i, (name, mesh)) in meshes.iter().enumerate() {
        for check in verify_all(&fixtures::random_collapse(mesh, i as u64)) {
            assert!(check.ok(), "{name}: {check:?}");
        }
    }
}

#[test]
fn long_meshes_are_compared_in_full_at_a_schedule_and_by_hash_everywhere() {
    let simplified = Arc::new(sphere());
    let reference = Reference::new(&simplified).expect("a sequence of ordinary length");
    let model = Interactive::build(&simplified).expect("triangles are in order");
    for stride in [0, 1, 7, u32::MAX] {
        let checks = verify(
            &model,
            &reference,
            &VerifyOptions { stride, jumps: 5, ..VerifyOptions::default() },
        );
        assert!(checks.iter().all(Check::ok));
        let steps = reference.steps() as u64;
        let wanted = match stride {
            0 | 1 => steps + 1,
            7 => steps.div_ceil(7) + 1,
            _ => 2,
        };
        assert_eq!(checks.iter().map(|c| c.lods).collect::<Vec<_>>(), [wanted, wanted, 5]);
        assert!(checks.iter().all(|c| c.full == c.lods), "{checks:?}");
    }
}

/// A defect of a model.
#[derive(Clone, Copy, PartialEq)]
enum Defect {
    Drops,
    Doubles,
    Flips,
    TellsTooLittle,
    ForgetsToRefine,
    StopsShort,
}

/// An Interactive Mesh with a defect from some LOD on.
struct Defective(Interactive, Defect, Lod);

impl Model for Defective {
    type Cursor = (<Interactive as Model>::Cursor, bool);

    fn name(&self) -> &'static str {
        "defective"
    }
    fn simplified(&self) -> &Arc<Simplified> {
        self.0.simplified()
    }
    fn cursor(&self) -> Self::Cursor {
        (self.0.cursor(), false)
    }
    fn lod(&self, cursor: &Self::Cursor) -> Lod {
        self.0.lod(&cursor.0)
    }
    fn seek(&self, cursor: &mut Self::Cursor, lod: Lod, changes: &mut impl Changes) -> Traffic {
        let from = self.lod(cursor);
        match self.1 {
            Defect::TellsTooLittle if lod >= self.2 => {
                return self.0.seek(&mut cursor.0, lod, &mut ());
            }
            Defect::StopsShort if lod >= self.2 => return Traffic::default(),
            Defect::ForgetsToRefine => cursor.1 = lod < from && lod <= self.2,
            _ => {}
        }
        self.0.seek(&mut cursor.0, lod, changes)
    }
    fn for_each_triangle(&self, cursor: &Self::Cursor, see: impl FnMut(OrientedTriangle)) {
        let mut triangles = self.0.triangles(&cursor.0);
        let defective = self.lod(cursor) >= self.2;
        match self.1 {
            Defect::Drops if defective => drop(triangles.pop()),
            Defect::Doubles if defective => triangles.extend(triangles.first().copied()),
            Defect::Flips if defective => {
                if let Some(t) = triangles.first_mut() {
                    *t = OrientedTriangle::new(
                        t.submesh,
                        [t.corners[0], t.corners[2], t.corners[1]],
                    );
                }
            }
            Defect::ForgetsToRefine if cursor.1 => drop(triangles.pop()),
            _ => {}
        }
        triangles.into_iter().for_each(see);
    }
    fn drawn(&self, cursor: &Self::Cursor) -> u64 {
        self.0.drawn(&cursor.0)
    }
    fn storage_to(&self, lod: Lod) -> StorageCost {
        self.0.storage_to(lod)
    }
    fn arrays(&self, _: Layout) -> Vec<Array> {
        Vec::new()
    }
}

#[test]
fn every_defect_of_a_model_is_found_at_its_first_lod() {
    let simplified = Arc::new(sphere());
    let reference = Reference::new(&simplified).expect("a sequence of ordinary length");
    let from = simplified.collapses().floor(Lod(40));
    let failures = |defect| -> Vec<Option<Failure>> {
        let model = Defective(
            Interactive::build(&simplified).expect("triangles are in order"),
            defect,
            from,
        );
        verify(&model, &reference, &VerifyOptions::default())
            .into_iter()
            .map(|c| c.failure)
            .collect()
    };
    assert!(
        matches!(failures(Defect::Drops)[0], Some(Failure::Missing { lod, .. }) if lod == from)
    );
    assert!(
        matches!(failures(Defect::Doubles)[0], Some(Failure::Extra { lod, .. }) if lod == from)
    );
    let flipped = failures(Defect::Flips);
    let flips = |failure: &Option<Failure>| {
        matches!(failure, Some(Failure::Missing { lod, .. } | Failure::Extra { lod, .. })
            if *lod == from)
    };
    assert!(flips(&flipped[0]));
    assert!(
        matches!(failures(Defect::TellsTooLittle)[0], Some(Failure::Changes { lod }) if lod == from)
    );
    let short = failures(Defect::StopsShort);
    assert!(matches!(short[0], Some(Failure::Stopped { wanted, .. }) if wanted == from));
    let refined = failures(Defect::ForgetsToRefine);
    assert_eq!(refined[0], None);
    assert!(
        matches!(refined[1], Some(Failure::Missing { lod, .. }) if lod == from),
        "{:?}",
        refined[1]
    );
}
