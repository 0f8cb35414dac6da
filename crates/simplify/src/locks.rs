//! The positions that options and guidance keep until the terminal phase.

use crate::Options;
use lodc_mesh::Mesh;

/// Returns the positions of locked vertices (`locked` has an entry for each, or none), and with
/// [`Options::lock_border`] those of borders.
pub(crate) fn locked_positions(mesh: &Mesh, options: &Options, locked: &[bool]) -> Vec<[f32; 3]> {
    let named = locked.iter().zip(mesh.positions()).filter(|(locked, _)| **locked);
    let mut positions: Vec<[f32; 3]> = named.map(|(_, &p)| p).collect();
    if options.lock_border {
        let border = mesh.border_edges();
        positions.extend(border.as_flattened().iter().map(|&v| mesh.positions()[v as usize]));
    }
    positions
}
