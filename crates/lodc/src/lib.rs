//! Continuous level of detail: every level between a full mesh and a single point.
//!
//! [`build()`] makes a file from glTF, GLB, OBJ, PLY or STL, [`open`] reads one; [`File::level`]
//! takes a level out of it:
//!
#![cfg_attr(all(feature = "build", feature = "export"), doc = "```")]
#![cfg_attr(not(all(feature = "build", feature = "export")), doc = "```ignore")]
//! use lodc::{Metric, Select};
//!
//! # std::env::set_current_dir("../..")?;
//! let file = lodc::build("fixtures/machine_part.glb").metric(Metric::Quadric).run()?;
//! let level = file.level(Select::Triangles(100))?;
//! for part in level.objects() {
//!     println!("{}: {} triangles, error {}", part.name(), part.indices().len(), part.error());
//! }
//! # let folder = std::env::temp_dir().join("lodc-front-door");
//! # std::fs::create_dir_all(&folder)?;
//! # std::env::set_current_dir(&folder)?;
//! level.write("part.100.glb")?;
//! file.write("part.lodc")?; // lodc::open reads it again
//! # assert_eq!(lodc::open("part.lodc")?.triangles(), 480);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Everything that it exchanges is plain: positions are `[f32; 3]`, triangles `[u32; 3]`,
//! attributes bytes with a type. The packages below have more: [`formats`] every byte of files,
//! [`mesh`] meshes and collapse sequences, [`models`] the structures of the thesis.
//!
//! | feature | gives |
//! | --- | --- |
//! | `read` (default) | `.lodc` files, their levels and models |
//! | `stream` | `.lods` streams: `formats::lods` |
//! | `import` | glTF, GLB, OBJ, PLY and STL as scenes |
//! | `build` | files from meshes; takes `import` |
//! | `export` | levels as glTF, GLB, OBJ and PLY |
//! | `gpu` | levels on a graphics device: `gpu::Levels` |

#[cfg(feature = "build")]
pub mod build;
mod container;
mod error;
mod file;
pub mod glide;
#[cfg(feature = "gpu")]
pub mod gpu;
#[cfg(feature = "import")]
mod input;
pub mod level_mesh;
pub mod levels;
mod meeting;
mod scene_levels;
mod shapes;

#[cfg(feature = "build")]
pub use build::Builder;
pub use container::{LodFile, LodObject, read, stored_bytes, write};
pub use error::Error;
pub use file::{File, Level, LevelObject, open};
#[cfg(feature = "import")]
pub use input::{Input, read_input};
pub use lodc_formats as formats;
pub use lodc_lod as models;
pub use lodc_mesh as mesh;
pub use lodc_scene as scene;
pub use lodc_select::SceneLevels;
pub use lodc_select::Target as Select;
#[cfg(feature = "build")]
pub use lodc_simplify::MetricKind as Metric;
pub use meeting::{parting_borders, parting_line};
pub use scene_levels::scene_levels;
pub use shapes::{stated_shapes, target_shapes};

/// Builds a file from a glTF, GLB, OBJ, PLY or STL file: [`Builder::run`] does the work.
#[cfg(feature = "build")]
#[must_use]
pub fn build(path: impl AsRef<std::path::Path>) -> Builder {
    Builder::new(path.as_ref())
}
