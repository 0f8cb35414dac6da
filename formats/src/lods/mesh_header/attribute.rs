//! The compact description of an attribute stream in an object's header: semantic, morph target,
//! component type and count.

use super::{byte, malformed, number};
use crate::FormatError;
use crate::lodc::manifest::{component, component_code};
use lodc_mesh::{Attribute, Semantic, put_leb128};

/// Flag of integers that stand for 0 to 1, or −1 to 1, in the byte of component type and count.
const NORMALIZED: u8 = 8;

/// Appends an attribute without its bytes.
pub(super) fn put_attribute(out: &mut Vec<u8>, attribute: &Attribute) {
    let (code, set_or_length) = match &attribute.semantic {
        Semantic::Position => (0, 0),
        Semantic::Normal => (1, 0),
        Semantic::Tangent => (2, 0),
        Semantic::TexCoord(set) => (3, *set),
        Semantic::Color(set) => (4, *set),
        Semantic::Joints(set) => (5, *set),
        Semantic::Weights(set) => (6, *set),
        Semantic::Custom(name) => (7, name.len() as u32),
    };
    put_leb128(out, code + 8 * u64::from(set_or_length));
    if let Semantic::Custom(name) = &attribute.semantic {
        out.extend_from_slice(name.as_bytes());
    }
    put_leb128(out, attribute.morph_target.map_or(0, |t| u64::from(t) + 1));
    let component = component_code(attribute.component);
    let normalized = if attribute.normalized { NORMALIZED } else { 0 };
    out.push(component | normalized | (attribute.components - 1) << 4);
}

/// Takes an attribute off the front.
pub(super) fn attribute(bytes: &mut &[u8]) -> Result<Attribute, FormatError> {
    let unknown = || malformed("has an attribute that is not known");
    let packed = lodc_mesh::take_leb128(bytes, u64::from(u32::MAX) * 8 + 7);
    let packed = packed.ok_or_else(unknown)?;
    let semantic = match (packed % 8, (packed / 8) as u32) {
        (0, 0) => Semantic::Position,
        (1, 0) => Semantic::Normal,
        (2, 0) => Semantic::Tangent,
        (3, set) => Semantic::TexCoord(set),
        (4, set) => Semantic::Color(set),
        (5, set) => Semantic::Joints(set),
        (6, set) => Semantic::Weights(set),
        (7, length) => {
            let (name, rest) = bytes.split_at_checked(length as usize).ok_or_else(unknown)?;
            *bytes = rest;
            Semantic::Custom(String::from_utf8(name.to_vec()).map_err(|_| unknown())?)
        }
        _ => return Err(unknown()),
    };
    let morph_target = match number(bytes)? {
        0 => None,
        n => Some(n - 1),
    };
    let kind = byte(bytes)?;
    Ok(Attribute {
        semantic,
        morph_target,
        component: component(kind & 7).ok_or_else(unknown)?,
        components: (kind >> 4) + 1,
        normalized: kind & NORMALIZED != 0,
        bytes: Vec::new(),
    })
}
