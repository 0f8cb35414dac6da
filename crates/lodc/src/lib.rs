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
//! | `export` | levels as glTF, GLB, OBJ, PLY and STL |
//! | `gpu` | levels on a graphics device: `gpu::ResidentObject` |

#[cfg(feature = "build")]
mod asset;
#[cfg(feature = "build")]
mod builder;
mod container;
mod error;
mod file;
pub mod geomorph;
#[cfg(feature = "gpu")]
pub mod gpu;
#[cfg(feature = "import")]
mod input;
pub mod level_mesh;
pub mod levels;
mod meeting;
#[cfg(feature = "build")]
pub mod pipeline;
#[cfg(feature = "export")]
mod rounding;
mod scene_levels;
mod shapes;
mod source;
#[cfg(feature = "export")]
mod written;

#[cfg(feature = "build")]
pub use asset::{Asset, Errors, Simplify};
#[cfg(feature = "build")]
pub use builder::Builder;
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
#[doc(inline)]
pub use lodc_select::Target as Select;
#[cfg(feature = "build")]
pub use lodc_simplify::MetricKind as Metric;
pub use meeting::{parting_borders, parting_line};
#[cfg(feature = "export")]
pub use rounding::Rounding;
pub use scene_levels::scene_levels;
pub use shapes::{stated_shapes, target_shapes};
pub use source::Source;
#[cfg(feature = "export")]
pub use written::{LevelOf, WrittenLevel, single};

/// Builds a file from a glTF, GLB, OBJ, PLY or STL file, given by its path, its bytes or a reader,
/// or from a mesh of arrays: [`Builder::run`] does the work.
///
/// ```
/// use lodc::mesh::{Attribute, Semantic};
/// use lodc::{Select, Source};
///
/// // A sheet of 20 × 20 quads, with texture coordinates.
/// let uv: Vec<[f32; 2]> =
///     (0..441).map(|v| [(v % 21) as f32 / 20.0, (v / 21) as f32 / 20.0]).collect();
/// let positions: Vec<[f32; 3]> =
///     uv.iter().map(|[u, v]| [*u, *v, 0.1 * (7.0 * u).sin()]).collect();
/// let quads = (0..400u32).map(|q| q % 20 + q / 20 * 21);
/// let triangles: Vec<[u32; 3]> =
///     quads.flat_map(|a| [[a, a + 1, a + 22], [a, a + 22, a + 21]]).collect();
/// let uv = Attribute::of_floats(Semantic::TexCoord(0), &uv);
///
/// let file = lodc::build(Source::arrays(positions, triangles, vec![uv])).run()?;
/// let level = file.level(Select::Ratio(0.1))?;
/// let part = level.objects().next().expect("one object");
/// assert!(part.indices().len() <= 80);
/// assert_eq!(part.attributes()[0].floats::<2>().expect("two each").len(), part.positions().len());
///
/// let bytes = file.to_bytes(); // a .lodc file
/// assert_eq!(lodc::open(&bytes)?.triangles(), 800);
/// # Ok::<(), lodc::Error>(())
/// ```
#[cfg(feature = "build")]
#[must_use]
pub fn build<'a>(source: impl Into<Source<'a>>) -> Builder<'a> {
    Builder::new(source.into())
}
