//! Levels of detail of `.lodc` files in [Bevy](https://bevy.org).
//!
//! [`LodcPlugin`] loads them as assets, with a [`Mesh`](bevy_mesh::Mesh) for each submesh of each
//! level that is asked for, and in every frame gives each entity with a [`LevelOfDetail`] the
//! coarsest level whose error cannot be seen through any [`LodEye`].
//!
//! ```
//! use bevy_app::App;
//! use bevy_asset::{AssetPlugin, AssetServer};
//! use bevy_transform::components::Transform;
//! use lodc_bevy::{LevelOfDetail, LodEye, LodcPlugin};
//!
//! let mut app = App::new();
//! app.add_plugins((bevy_app::TaskPoolPlugin::default(), AssetPlugin::default(), LodcPlugin));
//! let file = app.world().resource::<AssetServer>().load("part.lodc");
//! app.world_mut().spawn((LevelOfDetail::new(file, 0, 0), Transform::from_xyz(0.0, 0.0, -5.0)));
//! app.world_mut().spawn(LodEye::default()); // beside the camera
//! app.update();
//! ```
//!
//! Meshes have positions, normals, tangents, two sets of texture coordinates, colours, joints and
//! weights, as glTF means them. Materials are the host's: [`LodcObject::materials`] names them.

mod asset;
#[cfg(feature = "chain")]
mod chain;
mod choose;
mod mesh;

pub use asset::{
    LevelTarget, Lodc, LodcLevel, LodcLoader, LodcObject, LodcPlacement, LodcSettings,
};
#[cfg(feature = "chain")]
pub use chain::ChainLoader;
pub use choose::{LevelOfDetail, LodEye};

use bevy_app::{App, Plugin, PostUpdate};
use bevy_asset::AssetApp;
use bevy_ecs::schedule::IntoScheduleConfigs;
use bevy_transform::TransformSystems;

/// Adds the asset, its loader, and the system that chooses levels, which runs after transforms have
/// been propagated.
#[derive(Clone, Copy, Debug, Default)]
pub struct LodcPlugin;

impl Plugin for LodcPlugin {
    fn build(&self, app: &mut App) {
        app.init_asset::<Lodc>()
            .init_asset::<bevy_mesh::Mesh>()
            .init_asset_loader::<LodcLoader>()
            .add_systems(PostUpdate, choose::choose.after(TransformSystems::Propagate));
        #[cfg(feature = "chain")]
        app.init_asset_loader::<ChainLoader>();
    }
}
