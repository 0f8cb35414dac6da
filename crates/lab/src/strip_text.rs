//! Triangle strips as lines of text, and their vertex, primitive and cache figures, for `lodc
//! strips`.

use lodc_formats::SceneObject;
use lodc_mesh::Mesh;
use lodc_strip::{CacheModel, CacheOptions, StripKind, measure, order};
use std::fmt::Write;

/// Strips of some objects, one after the other: a line `s` and its vertices for each strip, or `l`
/// and its vertices for each submesh as a triangle list. Vertices are numbered as in their source,
/// or else through all objects.
#[derive(Clone, Debug, Default)]
pub struct StripText {
    /// The lines.
    pub text: String,
    /// Number of strips.
    pub strips: u64,
    /// Indices that are drawn.
    pub indices: u64,
    /// Vertices that a first-in-first-out cache of the size asked for misses.
    pub misses: u64,
    /// Vertices of the objects so far: those of the next start there.
    vertices: u64,
}

impl StripText {
    /// Adds an object: strips of a kind, or with none a triangle list for a vertex cache.
    pub fn add(&mut self, object: &SceneObject, kind: Option<StripKind>, options: &CacheOptions) {
        let (mesh, base) = (&object.mesh, self.vertices);
        let number = |v: u32| {
            object.source_positions.get(v as usize).map_or(base + u64::from(v), |&p| u64::from(p))
        };
        match kind {
            Some(kind) => {
                let strips = kind.generate(mesh, options);
                self.strips += strips.len() as u64;
                self.count(mesh, options.cache_size, strips.indices());
                strips.iter().for_each(|strip| self.line('s', number, strip));
            }
            None => {
                let list = order(mesh, options.cache_size);
                self.count(mesh, options.cache_size, list.as_flattened());
                // One line per submesh: lines are no longer than a part that is drawn at once.
                for submesh in mesh.submeshes() {
                    self.line('l', number, list[submesh.triangles()].as_flattened());
                }
            }
        }
        self.vertices += mesh.vertex_count() as u64;
    }

    /// Counts indices that are drawn, and the misses of a cache of `size` vertices.
    fn count(&mut self, mesh: &Mesh, size: u32, indices: &[u32]) {
        let cache = CacheModel { size, ..CacheModel::default() };
        self.indices += indices.len() as u64;
        self.misses += measure(indices.iter().copied(), mesh.vertex_count(), cache).misses;
    }

    /// Appends a line of vertex numbers, if there are any.
    fn line(&mut self, kind: char, number: impl Fn(u32) -> u64, vertices: &[u32]) {
        if vertices.is_empty() {
            return;
        }
        self.text.push(kind);
        for &v in vertices {
            // Writing to a string cannot fail.
            let _ = write!(self.text, " {}", number(v));
        }
        self.text.push('\n');
    }
}
