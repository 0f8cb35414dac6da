//! Which parts of a scene a level no longer shows: objects, materials, and a share of the visible
//! surface.

use lodc::{LodObject, SceneLevels};
use lodc_formats::{Document, FormatError, ObjectInfo, PartNames};
use lodc_measure::{Surface, TriangleTree, share_beyond};
use lodc_mesh::{Lod, OrientedTriangle};
use rayon::prelude::*;
use serde::Serialize;
use std::collections::BTreeSet;
use std::fmt;

/// A point of an object is gone if nothing of its level is within this share of the object's
/// diagonal. An object whose error is smaller has lost nothing. Chosen by hand, as are the next
/// two: smaller values name parts that people do not miss.
const GONE_DISTANCE: f64 = 0.05;
/// An object is named if more than this share of its visible area is gone.
const MIN_OBJECT_SHARE: f64 = 0.5;
/// The scene is named if more than this share of all visible area is gone.
const MIN_SCENE_SHARE: f64 = 0.02;

/// Something that a level no longer shows.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MissingPart {
    /// `object`, `material` or `surface`: that of the whole scene.
    pub kind: &'static str,
    /// The name of the object or material; none of the surface.
    pub name: Option<String>,
    /// The share of its visible area that is gone.
    pub share: f64,
}

impl fmt::Display for MissingPart {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { kind, name, share } = self;
        let percent = 100.0 * share;
        match name {
            Some(name) if *share >= 1.0 => write!(f, "the {kind} {name} is gone"),
            Some(name) => {
                write!(f, "the {kind} {name} is gone ({percent:.0} % of its visible surface)")
            }
            None => write!(f, "{percent:.1} % of the visible {kind} is gone"),
        }
    }
}

/// The parts of a scene, of which it finds those that a level no longer shows.
#[derive(Debug)]
pub struct PartInventory<'a> {
    objects: &'a [LodObject],
    scene: &'a SceneLevels<'a>,
    names: PartNames,
}

impl<'a> PartInventory<'a> {
    /// Objects, the scene that shows them, and the document with their names.
    ///
    /// # Errors
    /// If the document is damaged.
    pub fn new(
        objects: &'a [LodObject],
        scene: &'a SceneLevels<'a>,
        document: &Document,
    ) -> Result<Self, FormatError> {
        let infos: Vec<&ObjectInfo> = objects.iter().map(|o| &o.info).collect();
        Ok(Self { objects, scene, names: PartNames::new(document, &infos)? })
    }

    /// The parts that are gone if the objects are at `lods`, one each. Materials without names are
    /// left out.
    #[must_use]
    pub fn gone(&self, lods: &[Lod]) -> Vec<MissingPart> {
        let error = |(object, &lod): (&LodObject, &Lod)| {
            let collapses = object.simplified.collapses();
            if collapses.is_measured() { collapses.error_at(lod).into() } else { f64::INFINITY }
        };
        self.gone_at(lods, self.objects.iter().zip(lods).map(error))
    }

    /// As [`Self::gone`], with other bounds of the levels' errors than the stored ones: one for
    /// each object, in mesh units.
    #[must_use]
    pub fn gone_at(&self, lods: &[Lod], errors: impl IntoIterator<Item = f64>) -> Vec<MissingPart> {
        if lods.iter().all(|lod| lod.0 == 0) {
            return Vec::new();
        }
        let live: Vec<Vec<OrientedTriangle>> = (self.objects.par_iter().zip(lods))
            .map(|(object, &lod)| object.simplified.triangles_at(lod))
            .collect();
        let share = |(o, error)| self.lost_share(o, error, &live[o]);
        let shares: Vec<f64> = errors.into_iter().enumerate().map(share).collect();
        let mut gone = Vec::new();
        for (object, &share) in self.objects.iter().zip(&shares) {
            if share > MIN_OBJECT_SHARE {
                gone.push(MissingPart {
                    kind: "object",
                    name: Some(object.info.name.clone()),
                    share,
                });
            }
        }
        for name in self.lost_materials(&live) {
            gone.push(MissingPart { kind: "material", name: Some(name), share: 1.0 });
        }
        if shares.iter().any(|&share| share > 0.0) {
            let areas = || self.scene.visible_areas().iter().map(|areas| areas.iter().sum::<f64>());
            let lost: f64 = areas().zip(&shares).map(|(area, share)| area * share).sum();
            let share = lost / areas().sum::<f64>();
            if share > MIN_SCENE_SHARE {
                gone.push(MissingPart { kind: "surface", name: None, share });
            }
        }
        gone
    }

    /// The share of an object's visible area that is gone at a level whose error is at most
    /// `error`. `live` has the triangles of the level.
    fn lost_share(&self, number: usize, error: f64, live: &[OrientedTriangle]) -> f64 {
        let mesh = self.objects[number].simplified.mesh();
        let gone_distance = GONE_DISTANCE * mesh.diagonal();
        if mesh.triangles().is_empty() || live.len() == mesh.triangles().len() {
            return 0.0;
        }
        if live.is_empty() {
            return 1.0;
        }
        if error <= gone_distance {
            return 0.0;
        }
        let surface = Surface {
            positions: mesh.positions().iter().map(|&p| p.into()).collect(),
            triangles: mesh.triangles().to_vec(),
            ..Surface::default()
        };
        let corners = |t: &OrientedTriangle| {
            t.corners.map(|v| mesh.positions()[v as usize].map(f64::from).into())
        };
        let level = TriangleTree::new(&live.iter().map(corners).collect::<Vec<_>>());
        share_beyond(&surface, &self.scene.visible_areas()[number], &level, gone_distance)
    }

    /// Materials of which the input has triangles and the level none.
    fn lost_materials(&self, live: &[Vec<OrientedTriangle>]) -> BTreeSet<String> {
        let (mut in_input, mut in_level) = (BTreeSet::new(), BTreeSet::new());
        for ((object, live), names) in self.objects.iter().zip(live).zip(&self.names.materials) {
            let submeshes = object.simplified.mesh().submeshes();
            let used = submeshes.iter().zip(names).filter(|(s, _)| s.triangle_count > 0);
            in_input.extend(used.map(|(_, name)| name));
            let mut has_triangles = vec![false; names.len()];
            live.iter().for_each(|t| has_triangles[t.submesh as usize] = true);
            let used = names.iter().zip(has_triangles).filter(|(_, has_triangles)| *has_triangles);
            in_level.extend(used.map(|(name, _)| name));
        }
        in_input.difference(&in_level).filter(|n| !n.is_empty()).map(|n| (*n).clone()).collect()
    }
}
