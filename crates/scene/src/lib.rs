//! Scenes as plain data: where objects are, how they are posed, and what they look like.
//! Importers create this data. Everything that shows or measures a scene uses the few computations
//! here.
//!
//! A [`Graph`] has nodes, skins and the roots of the default scene. A [`Pose`] says how its nodes
//! are relative to their parents and how much of each morph target is blended in;
//! [`Graph::rest_pose`] is the one of the file. Together they give an [`Arrangement`] of
//! [`Placement`]s: an object, the transform of the node that shows it, its joints' matrices and its
//! morph weights.
//!
//! The *surface of a scene* is what the default scene shows in its rest pose. Pictures and
//! comparisons mean this surface; errors and world scales count all placements, and the moments at
//! which animations stretch them ([`Motion`]).
//!
//! ```
//! use lodc_scene::{Graph, LocalTransform, Motion, Node, posed_positions};
//!
//! let mesh = lodc_fixtures::named("cube").expect("a shape");
//! // A node twice as large as the object that it shows.
//! let scale = LocalTransform::Trs {
//!     translation: [0.0; 3],
//!     rotation: [0.0, 0.0, 0.0, 1.0],
//!     scale: [2.0; 3],
//! };
//! let node = Node { local: scale, objects: vec![0], ..Node::default() };
//! let graph = Graph { nodes: vec![node], roots: vec![0], skins: Vec::new() };
//!
//! let scene = Motion::new(graph, Vec::new(), 1);
//! assert_eq!(scene.measured_placements(&mesh, 0).scale, 2.0);
//! let shown = posed_positions(&mesh, &scene.rest().placements()[0]);
//! assert_eq!(shown[0], 2.0 * glam::Vec3::from(mesh.positions()[0]).as_dvec3());
//! ```

mod animation;
mod graph;
mod image;
mod material;
mod motion;
mod normals;
mod placement;
mod pose;
mod posed;
mod scale;
mod shape;
mod srgb;
mod transform;

pub use animation::{Animation, Channel, Interpolation, Property};
pub use graph::{Graph, Node, Skin};
pub use image::Image;
pub use material::{AlphaMode, Appearance, Coordinates, Material, Texture, Wrap};
pub use motion::{
    MAX_TARGET_SHAPES, MeasuredPlacement, MeasuredPlacements, Motion, ObjectShapes, SeenPositions,
    Stretch, TargetShape,
};
pub use normals::{flat_normals, smooth_normals};
pub use placement::{Arrangement, Placement, evenly_spread, share_in_pictures};
pub use pose::Pose;
pub use posed::{PosedVertices, centre, follows_joints, posed, posed_positions, stream};
pub use scale::placement_scales;
pub use shape::Shape;
pub use srgb::{srgb_value, to_linear, to_srgb};
pub use transform::{
    LocalTransform, Transform, largest_stretch, transform_from_columns, transform_normal,
};
