//! The array in which models store strips: writing it, and reading it with every count checked.

use lodc_mesh::{Mesh, put_leb128};
use lodc_model::bytes::{Reader, put_narrow};
use lodc_model::{Array, BuildError, Layout};
use lodc_strip::{StripKind, StripSet, Strips};

/// Name of the array that holds strips.
pub(crate) const STRIPS: &str = "strips";

/// The strips as an array: the generator's number (a byte), for each submesh its number of strips
/// (varint), for each strip its length (varint), then all vertices, each as wide as the largest
/// vertex needs. Wide, all of these are `u32`.
pub(crate) fn to_array(strips: &Strips, vertices: usize, layout: Layout) -> Array {
    let wide = layout == Layout::Gpu;
    let mut bytes = Vec::new();
    put_narrow(&mut bytes, strips.kind as u32, if wide { 4 } else { 1 });
    let submeshes = (0..strips.submesh_count()).map(|s| strips.submesh(s).len());
    for count in submeshes.chain(strips.iter().map(<[u32]>::len)) {
        if wide {
            put_narrow(&mut bytes, count as u32, 4);
        } else {
            put_leb128(&mut bytes, count as u64);
        }
    }
    let width = layout.width(vertices);
    strips.indices().iter().for_each(|&v| put_narrow(&mut bytes, v, width));
    Array { name: STRIPS.to_owned(), bytes, wide }
}

/// Reads strips from what [`to_array`] gave out. They need not draw the mesh: that is for
/// verification to find.
pub(crate) fn from_array(array: &Array, mesh: &Mesh) -> Result<Strips, BuildError> {
    let wrong = |what: &str| BuildError::Malformed { array: STRIPS, what: what.to_owned() };
    let short = || wrong("ends early or has a malformed number");
    let mut reader = Reader::new(&array.bytes);
    let layout = if array.wide { Layout::Gpu } else { Layout::Packed };
    let number = |reader: &mut Reader<'_>| match layout {
        Layout::Packed => reader.varint(),
        Layout::Gpu => reader.narrow(4),
    };
    let kind = reader.narrow(layout.width(1)).and_then(|kind| StripKind::ALL.get(kind as usize));
    let kind = *kind.ok_or_else(|| wrong("is of a generator that this version does not know"))?;
    let mut count = 0u32;
    let mut submesh_ends = Vec::with_capacity(mesh.submeshes().len());
    for _ in mesh.submeshes() {
        count = count.checked_add(number(&mut reader).ok_or_else(short)?).ok_or_else(short)?;
        submesh_ends.push(count);
    }
    if count as usize > reader.remaining() {
        return Err(short());
    }
    let mut end = 0u32;
    let mut ends = Vec::with_capacity(count as usize);
    for _ in 0..count {
        let length = number(&mut reader).ok_or_else(short)?;
        if length < 3 {
            return Err(wrong("has a strip of fewer than three vertices"));
        }
        end = end.checked_add(length).ok_or_else(short)?;
        ends.push(end);
    }
    let width = layout.width(mesh.vertex_count());
    if (end as usize).checked_mul(width) != Some(reader.remaining()) {
        return Err(wrong("has another length than its strips"));
    }
    let mut indices = Vec::with_capacity(end as usize);
    for _ in 0..end {
        indices.push(reader.narrow(width).ok_or_else(short)?);
    }
    let set =
        StripSet::from_parts(indices, ends, submesh_ends).map_err(|e| wrong(&e.to_string()))?;
    check_submeshes(&set, mesh)?;
    Ok(Strips { kind, set })
}

/// Checks that strips have vertices of their own submesh only.
///
/// # Errors
/// If a vertex does not exist or belongs to another submesh.
pub fn check_submeshes(strips: &StripSet, mesh: &Mesh) -> Result<(), BuildError> {
    let wrong = |what: &str| Err(BuildError::Malformed { array: STRIPS, what: what.to_owned() });
    if strips.submesh_count() != mesh.submeshes().len() {
        return wrong("has another number of submeshes than the mesh");
    }
    for (strip, submesh) in strips.iter().zip(strips.submeshes()) {
        if strip.iter().any(|&v| mesh.vertex_submesh().get(v as usize) != Some(&submesh)) {
            return wrong("has a vertex that does not exist or belongs to another submesh");
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use lodc_fixtures as fixtures;
    use lodc_strip::Effort;

    #[test]
    fn strips_come_back_from_their_array_and_damage_is_refused() {
        for seed in 0..20 {
            let simplified = fixtures::random_collapse(&fixtures::random(seed), seed);
            let mesh = simplified.mesh();
            for kind in [StripKind::Stripe, StripKind::Cache] {
                let strips = Strips::generate(&simplified, kind, Effort::Fast);
                assert_eq!(strips.check(mesh), Ok(()), "random {seed}");
                for layout in Layout::ALL {
                    let array = to_array(&strips, mesh.vertex_count(), layout);
                    assert_eq!(from_array(&array, mesh), Ok(strips.clone()));
                    for cut in 0..array.bytes.len() {
                        let cut = Array { bytes: array.bytes[..cut].to_vec(), ..array.clone() };
                        assert!(from_array(&cut, mesh).is_err(), "random {seed}");
                    }
                    let longer = Array { bytes: [&array.bytes[..], &[0]].concat(), ..array };
                    assert!(from_array(&longer, mesh).is_err());
                }
            }
        }
        let mesh = fixtures::icosphere(1);
        let bomb = |bytes, wide| Array { name: STRIPS.to_owned(), bytes, wide };
        assert!(from_array(&bomb(vec![0, 0xff, 0xff, 0xff, 0xff, 0x0f], false), &mesh).is_err());
        assert!(from_array(&bomb(vec![0, 0, 0, 0, 0xff, 0xff, 0xff, 0xff], true), &mesh).is_err());
    }
}
