//! Chooses levels of detail for all objects of a scene by a target: an error, a share of the
//! triangles, a number of them.
//!
//! [`select`] does it. Under an error target each object meets the bound by itself. A triangle
//! target is shared: the removals with the least error go first, so asking for more triangles never
//! gives a larger error. Among nearly equal errors the one that costs the scene least for each
//! triangle ([`losses`]) goes first. [`SceneLevels`] applies this to the objects of a scene,
//! [`SceneViews`] chooses a level for every part of their surfaces, and [`SceneManager`] levels for
//! many instances, frame by frame.
//!
//! ```
//! use lodc_scene::{Arrangement, Graph};
//! use lodc_select::{Candidate, Target, losses, select};
//!
//! // A sphere and a cube; the cube is cut into as many triangles although it is flat.
//! let simplified: Vec<_> = ["icosphere", "cube"]
//!     .map(|name| {
//!         let mesh = lodc_fixtures::named(name).expect("a shape");
//!         lodc_simplify::simplify(&mesh, &lodc_simplify::Options::DEFAULT, &|_, _| ())
//!     })
//!     .into();
//! let graph = Graph::of_objects(2);
//! let scene = Arrangement::new(&graph, &graph.rest_pose(), 2);
//! let candidates: Vec<Candidate> = simplified
//!     .iter()
//!     .map(|s| Candidate {
//!         name: "shape",
//!         collapses: s.collapses(),
//!         scale: 1.0,
//!         diagonal: s.mesh().diagonal(),
//!         coarsest: s.coarsest(),
//!         rounding: 0.0,
//!     })
//!     .collect();
//! let objects: Vec<_> = simplified.iter().collect();
//! let (target, per_object) = (Target::Ratio(0.25), false);
//! let chosen = select(&candidates, target, per_object, || losses(&objects, &scene));
//! assert_eq!(chosen.expect("only Target::Lod can fail").lods.len(), 2);
//! ```

mod budget;
mod candidate;
mod levels;
mod loss;
mod number;
mod order;
pub mod parse;
mod quadric;
mod selection;
mod views;
mod visibility;

pub use budget::{CurveLevel, Goal, Instance, LevelCurve, SceneManager, View};
pub use candidate::Candidate;
pub use levels::{ObjectLevels, SceneLevels, SelectError};
pub use loss::losses;
pub use number::{decimal, rounded_error, rounded_rms};
pub use order::{RankedLod, ranks};
pub use quadric::accumulated_error;
pub use selection::{RecordError, Selection, Target, scene_diagonal, select};
pub use views::{Criterion, SceneViews, ShownScene, ViewOptions};
