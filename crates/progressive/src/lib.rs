//! Progressive streams: a simplified mesh as entropy-coded vertex splits, coarse to fine.
//!
//! The idea is Hoppe's progressive mesh (1996). A split sends what a *package* of Ripollés' thesis
//! (2009, 4.3.3; "the thesis" in comments) holds for it, entropy-coded. The container is
//! `lodc_formats::lods`, and `docs/STREAM.md` specifies every bit.
//!
//! # The stream in nine sentences
//!
//! 1. A collapse sequence, read backwards, is a sequence of *vertex splits* that turns one vertex
//!    into the whole mesh. The vertices before the first triangle are *points*; each comes when a
//!    split needs it.
//! 2. Splits come in *batches*: each batch is a pass through a list of all wedge groups (the
//!    vertices at one position), with a bit for each group that says whether it is split. If every
//!    level is wanted, the order is *exact* instead, and each split names its *parent*.
//! 3. A split adds *new triangles*, mostly one on each side of the edge from parent to new vertex,
//!    coded by the indices of their third corners in the parent's link.
//! 4. It *transfers* some triangles of the parent's star to the new vertex. Which ones mostly
//!    follows from the new triangles.
//! 5. It gives the new vertex its *values*: those of a vertex nearby, or residuals to a prediction
//!    from the vertices around.
//! 6. Consecutive splits of one collapse, one for each wedge, are a *step*; a batch ends with the
//!    errors of the level after it. A *block*, the part of a stream that is decoded at once, has
//!    steps of one object, or of several that take *turns*, each of some batches.
//! 7. A bit is coded with an *adaptive probability*, chosen by context and updated after each use;
//!    or plainly, where both values are equally likely.
//! 8. The same generic code encodes and decodes, so that the two sides cannot differ; what only an
//!    encoder knows it asks of a *split source*.
//! 9. The bytes of a stream bound the memory and time that its steps may take, so no crafted stream
//!    can exhaust a decoder.
//!
//! # A vertex split
//!
//! ```text
//!        before                                after
//!
//!      p ------- q                         p ------- q
//!     / \       / \                       / \       / \        the triangles above are
//!    /   \     /   \                     /   \     /   \       transferred to the new vertex
//!   /     \   /     \                   /     \   /     \
//! v_l -- parent --- v_r      split    v_l ---- new ----- v_r   left triangle  (new, v_l, parent)
//!   \     /   \     /       ------->    \       |       /      right triangle (new, parent, v_r)
//!    \   /     \   /        <-------     \      |      /
//!     \ /       \ /         collapse      `-- parent -´        the triangles below
//!      r ------- s                         r /   \ s           stay with the parent
//! ```
//!
//! # Folders
//!
//! | folder | concern |
//! | --- | --- |
//! | `entropy` | adaptive probabilities, coder (range variant of ANS), integer codes, text |
//! | `partial_mesh` | the mesh so far: corner lists, stars, links, splits |
//! | `vertex_data` | number systems, layouts, quantisation, prediction of values |
//! | `source` | what an encoder knows: the splits of a collapse sequence |
//! | `vertex_split` | coding of splits: parent, triangles, corners, points, turns, contexts |
//! | this one | headers; encoders and decoders of blocks of one object and of several (`turns_*`) |
//!
//! # Example
//!
//! Encode a sphere in blocks, and decode them one after the other:
//!
//! ```
//! use lodc_progressive::{BlockTarget, Contexts, MeshDecoder, MeshEncoder, StepBlock, StepOrder,
//! VertexLayout};
//!
//! let sphere = lodc_fixtures::random_collapse(&lodc_fixtures::icosphere(2), 7);
//! let mut encoder = MeshEncoder::new(&sphere, VertexLayout::choose(&sphere), StepOrder::Batches);
//! let header = encoder.header().clone();
//! let (mut contexts, mut blocks, mut bytes) = (Contexts::new(), Vec::new(), 0);
//! while !encoder.is_complete() {
//!     let target = BlockTarget { bytes: 200, bytes_before: bytes, until_triangle: false };
//!     let block = encoder.encode(&mut contexts, target);
//!     bytes += block.splits.len();
//!     blocks.push(block);
//! }
//! assert!(blocks.len() > 5);
//!
//! let (mut decoder, mut contexts) = (MeshDecoder::new(header), Contexts::new());
//! let (mut coarser, mut bytes) = (0, 0);
//! for block in &blocks {
//!     bytes += block.splits.len(); // so far: they bound what is decoded
//!     let steps = StepBlock { steps: block.steps, splits: &block.splits, bytes };
//!     decoder.decode(&mut contexts, steps)?;
//!     // Every prefix is a mesh: the one of a level of detail.
//!     assert!(decoder.triangle_count() >= coarser);
//!     coarser = decoder.triangle_count();
//! }
//! assert!(decoder.is_complete());
//! assert_eq!(decoder.triangles().len(), sphere.mesh().triangles().len());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod entropy;
mod error_code;
mod header;
mod invalid;
mod mesh_decoder;
mod mesh_encoder;
mod partial_mesh;
mod source;
#[cfg(test)]
mod trace;
mod turns_decoder;
mod turns_encoder;
mod vertex_data;
mod vertex_split;

pub use entropy::text_codec::TextCodec;
pub use header::MeshHeader;
pub use invalid::InvalidStream;
pub use mesh_decoder::{MeshDecoder, StepBlock};
pub use mesh_encoder::{BlockTarget, EncodedSteps, MeshEncoder};
pub use source::batches::{StepOrder, in_batches, with_removals};
pub use turns_decoder::decode_turns;
pub use turns_encoder::TurnsEncoder;
pub use vertex_data::number_system::NumberSystem;
pub use vertex_data::octahedral::Octahedral;
pub use vertex_data::quantize::{ErrorBound, Quantize};
pub use vertex_data::vertex_layout::{AttributeStream, Prediction, VertexLayout};
pub use vertex_split::contexts::Contexts;
