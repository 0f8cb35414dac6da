//! The choice of levels by what is seen.

use crate::asset::{Lodc, LodcObject};
use bevy_asset::{Assets, Handle};
use bevy_ecs::prelude::{Commands, Component, Query, Res};
use bevy_mesh::Mesh3d;
use bevy_transform::components::{GlobalTransform, Transform};

/// A submesh of an object whose level follows from what is seen of it: the system gives the entity
/// its mesh.
#[derive(Component, Clone, Debug)]
#[require(Mesh3d, Transform)]
pub struct LevelOfDetail {
    /// The file.
    pub file: Handle<Lodc>,
    /// Index of the object.
    pub object: usize,
    /// Index of the submesh.
    pub submesh: usize,
    /// Index of the level that is shown; none until the file is loaded.
    pub level: Option<usize>,
}

impl LevelOfDetail {
    /// Shows nothing until the file is loaded.
    #[must_use]
    pub fn new(file: Handle<Lodc>, object: usize, submesh: usize) -> Self {
        Self { file, object, submesh, level: None }
    }
}

/// An eye that levels are chosen for; put it beside a camera. With several, no error is too large
/// for any of them; without one everything is at its finest level.
#[derive(Component, Clone, Copy, Debug)]
#[require(Transform)]
pub struct LodEye {
    /// Pixels that an error may take on the screen.
    pub pixels: f32,
    /// Vertical field of view in radians.
    pub fovy: f32,
    /// Height of the screen in pixels.
    pub height: f32,
}

impl Default for LodEye {
    /// One pixel of 1,080, and the field of view of Bevy's cameras.
    fn default() -> Self {
        Self { pixels: 1.0, fovy: std::f32::consts::FRAC_PI_4, height: 1080.0 }
    }
}

impl LodEye {
    /// The error that takes [`Self::pixels`] pixels at a distance, in world units.
    #[must_use]
    pub fn allowed(&self, distance: f32) -> f32 {
        self.pixels * 2.0 * (self.fovy / 2.0).tan() / self.height * distance
    }
}

impl Lodc {
    /// Spawns the scene of a file that has been loaded: an entity for each submesh of each
    /// placement.
    pub fn spawn(&self, file: &Handle<Lodc>, commands: &mut Commands) {
        for placement in &self.placements {
            for submesh in 0..self.objects[placement.object].materials.len() {
                let level = LevelOfDetail::new(file.clone(), placement.object, submesh);
                commands.spawn((level, placement.transform));
            }
        }
    }
}

impl LodcObject {
    /// Index of the coarsest level whose error no eye can see, with the object at `transform`.
    #[must_use]
    pub fn seen<'a>(
        &self,
        transform: &GlobalTransform,
        eyes: impl Iterator<Item = (&'a LodEye, &'a GlobalTransform)>,
    ) -> usize {
        let matrix = transform.affine().matrix3;
        let scale = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|axis| axis.length());
        let scale = scale.into_iter().fold(0.0, f32::max);
        let centre = transform.transform_point(self.centre);
        let allowed = |(eye, at): (&LodEye, &GlobalTransform)| {
            // To the nearest point of the object, or nearer.
            let distance = at.translation().distance(centre) - scale * self.radius;
            eye.allowed(distance.max(0.0))
        };
        let allowed = eyes.map(allowed).reduce(f32::min).unwrap_or(0.0);
        let levels_within = self.levels.partition_point(|level| scale * level.error <= allowed);
        levels_within.saturating_sub(1)
    }
}

/// Gives every entity the mesh of its level. Entities whose level stays are not marked as changed.
#[expect(clippy::needless_pass_by_value, reason = "systems take what they ask for by value")]
pub(crate) fn choose(
    files: Res<Assets<Lodc>>,
    eyes: Query<(&LodEye, &GlobalTransform)>,
    mut entities: Query<(&mut LevelOfDetail, &GlobalTransform, &mut Mesh3d)>,
) {
    for (mut lod, transform, mut mesh) in &mut entities {
        let Some(object) = files.get(&lod.file).and_then(|file| file.objects.get(lod.object))
        else {
            continue;
        };
        let level = object.seen(transform, eyes.iter());
        let Some(chosen) = object.levels.get(level).and_then(|l| l.meshes.get(lod.submesh)) else {
            continue;
        };
        if lod.level != Some(level) || mesh.0 != *chosen {
            lod.level = Some(level);
            mesh.0 = chosen.clone();
        }
    }
}
