//! The statements of an OBJ as arrays: read by tobj behind a guard.

use super::feed::{Blocks, Feed};
use super::guard::{Guard, Guarded};
use super::parsed::Parsed;
use crate::{Fault, FormatError, Limits};
use std::sync::mpsc::sync_channel;

/// Reads all statements.
pub(super) fn parse(bytes: &[u8], limits: &Limits) -> Result<Parsed, FormatError> {
    let (mut models, mut guarded) = read(bytes, limits, false)?;
    if guarded.colors_came_late {
        (models, guarded) = read(bytes, limits, true)?;
    }
    let mut parsed = std::mem::take(&mut guarded.parsed);
    let [positions, texcoords, normals] = guarded.counts.map(|n| n as usize);
    parsed.faces.positions.resize(positions, [0.0; 3]);
    parsed.faces.texcoords.resize(texcoords, [0.0; 2]);
    parsed.faces.normals.resize(normals, [0.0; 3]);
    if !parsed.faces.texcoords_w.is_empty() {
        parsed.faces.texcoords_w.resize(texcoords, 0.0);
    }
    parsed.faces.colors.resize(if guarded.colored { positions } else { 0 }, [1.0; 4]);
    let mut undo = Undo { first_uses: guarded.first_uses.each_ref().map(|f| &f[..]) };
    // One after another, so that each one's memory is free before the next one's is taken.
    for model in models.drain(..) {
        undo.take(&model.mesh, guarded.corners, &mut parsed);
    }
    for (color, &alpha) in parsed.faces.colors.iter_mut().zip(&guarded.alphas) {
        color[3] = alpha;
    }
    guarded.forget_missing(&mut parsed);
    Ok(parsed)
}

/// Lets tobj read what the guard passes on, while the guard is ahead in a thread of its own.
fn read(
    bytes: &[u8],
    limits: &Limits,
    colored: bool,
) -> Result<(Vec<tobj::Model>, Guarded), FormatError> {
    // Raw index lists: tobj's own triangulation is a fan even where a polygon is not convex.
    let options = tobj::LoadOptions { single_index: false, ..tobj::LoadOptions::default() };
    let (sender, receiver) = sync_channel(4);
    let (models, guarded) = std::thread::scope(|scope| {
        let guard = scope.spawn(|| Guard::new(bytes, limits, colored, Blocks::new(sender)).run());
        let no_materials = |_: &std::path::Path| Err(tobj::LoadError::GenericFailure);
        let models = tobj::load_obj_buf(&mut Feed::new(receiver), &options, no_materials);
        (models, guard.join().expect("the guard returns its errors"))
    });
    let guarded = guarded?;
    let refused = |e: tobj::LoadError| FormatError::new(Fault::Malformed, "", e.to_string());
    Ok((models.map_err(refused)?.0, guarded))
}

/// Undoes tobj's numbering: each of its models numbers positions, texture coordinates and normals
/// anew, in order of first use.
struct Undo<'a> {
    /// Of each kind: the file's indices in order of first use, model after model.
    first_uses: [&'a [u32]; 3],
}

impl Undo<'_> {
    /// Moves a model's values to where the file has them, and its first `corners` to the end of
    /// the corner lists; later models only have values that no face uses.
    fn take(&mut self, mesh: &tobj::Mesh, corners: u32, parsed: &mut Parsed) {
        let [v, t, n] =
            [mesh.positions.len() / 3, mesh.texcoords.len() / 2, mesh.normals.len() / 3];
        let mut next = 0;
        let first_uses = [v, t, n].map(|count| {
            let (now, later) = self.first_uses[next].split_at(count);
            self.first_uses[next] = later;
            next += 1;
            now
        });
        scatter(&mesh.positions, first_uses[0], &mut parsed.faces.positions);
        scatter(&mesh.texcoords, first_uses[1], &mut parsed.faces.texcoords);
        scatter(&mesh.normals, first_uses[2], &mut parsed.faces.normals);
        for (rgb, &at) in mesh.vertex_color.as_chunks::<3>().0.iter().zip(first_uses[0]) {
            parsed.faces.colors[at as usize][..3].copy_from_slice(rgb);
        }
        if parsed.faces.corner_v.len() as u32 >= corners {
            return;
        }
        let mut end = parsed.faces.corner_v.len() as u32;
        if mesh.face_arities.is_empty() {
            parsed.faces.face_ends.extend((1..=mesh.indices.len() as u32 / 3).map(|i| end + 3 * i));
        }
        parsed.faces.face_ends.extend(mesh.face_arities.iter().map(|&arity| {
            end += arity;
            end
        }));
        let file = |kind: usize| move |&i: &u32| first_uses[kind][i as usize];
        parsed.faces.corner_v.extend(mesh.indices.iter().map(file(0)));
        parsed.faces.corner_t.extend(mesh.texcoord_indices.iter().map(file(1)));
        parsed.faces.corner_n.extend(mesh.normal_indices.iter().map(file(2)));
    }
}

fn scatter<const N: usize>(values: &[f32], at: &[u32], all: &mut [[f32; N]]) {
    for (value, &at) in values.as_chunks::<N>().0.iter().zip(at) {
        // Where a file has no positions at all, tobj was given one.
        if let Some(place) = all.get_mut(at as usize) {
            *place = *value;
        }
    }
}

#[cfg(test)]
#[path = "parse_tests.rs"]
mod tests;
