//! Writes binary STL: the triangles alone, each with the normal that follows from its corners.

use super::{FACET_BYTES, TEXT_BYTES};
use crate::flatten::Placed;
use crate::{Fault, FormatError, GENERATOR, OutputFile};
use std::path::Path;

/// Makes the file.
///
/// # Errors
/// If there are more triangles than an STL can count.
pub(crate) fn export(path: &Path, placed: &[Placed<'_>]) -> Result<Vec<OutputFile>, FormatError> {
    let triangles: usize = placed.iter().map(|p| p.object.mesh.triangles().len()).sum();
    let count = u32::try_from(triangles).map_err(|_| {
        let problem = format!("{triangles} triangles are too many for an STL");
        FormatError::new(Fault::Unsupported, "", problem)
    })?;
    let mut bytes = GENERATOR.as_bytes().to_vec();
    // The text must not begin with `solid`.
    bytes.resize(TEXT_BYTES, b' ');
    bytes.extend_from_slice(&count.to_le_bytes());
    bytes.reserve(triangles * FACET_BYTES);
    for p in placed {
        let vertices = p.vertices();
        for &triangle in p.object.mesh.triangles() {
            let corners = vertices.corners(triangle).map(|v| vertices.position(v));
            for value in [normal(corners)].iter().chain(&corners).flatten() {
                bytes.extend_from_slice(&value.to_le_bytes());
            }
            // Attributes: none.
            bytes.extend_from_slice(&[0; 2]);
        }
    }
    Ok(vec![OutputFile { path: path.to_owned(), bytes }])
}

/// The unit normal of a triangle; zero if it has no area.
fn normal(corners: [[f32; 3]; 3]) -> [f32; 3] {
    let [a, b, c] = corners.map(|p| p.map(f64::from));
    let ([ux, uy, uz], [vx, vy, vz]) = (minus(b, a), minus(c, a));
    let cross = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
    let length = cross.iter().map(|x| x * x).sum::<f64>().sqrt();
    cross.map(|x| if length > 0.0 { (x / length) as f32 } else { 0.0 })
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] - b[i])
}
