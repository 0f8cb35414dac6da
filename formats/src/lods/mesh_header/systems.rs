//! The number systems (quantisation step, or exact floats) of an object's positions and attributes,
//! as its header stores them.

use super::{byte, malformed};
use crate::FormatError;
use lodc_mesh::{Attribute, Component};
use lodc_progressive::{NumberSystem, Octahedral};

// The byte with which a number system begins.
/// Exact floats.
const FLOAT: u8 = 0;
/// Exact integers.
const INTEGER: u8 = 1;
/// A quantisation grid: its step and the origin of each channel follow.
const GRID: u8 = 2;
/// Unit vectors in octahedral coding: the number of bits follows, then the system of the components
/// after the direction.
pub(super) const OCTAHEDRAL: u8 = 3;
/// Decimal fractions: plus the number of digits after the point, up to 9.
const DECIMAL: u8 = 16;
const MAX_DECIMAL: u8 = DECIMAL + 9;
/// Numbers of few significant decimal digits: plus their number, 1 to 7.
const SIGNIFICANT: u8 = 32;
const MIN_SIGNIFICANT: u8 = SIGNIFICANT + 1;
const MAX_SIGNIFICANT: u8 = SIGNIFICANT + 7;

/// Appends the system of a stream with these channels; nothing without any.
pub(super) fn put(out: &mut Vec<u8>, channels: &[NumberSystem]) {
    let Some(first) = channels.first() else { return };
    match *first {
        NumberSystem::Float => out.push(FLOAT),
        NumberSystem::Integer => out.push(INTEGER),
        NumberSystem::Decimal(n) => out.push(DECIMAL + n),
        NumberSystem::Significant(n) => out.push(SIGNIFICANT + n),
        NumberSystem::Grid { step, .. } => {
            out.push(GRID);
            out.extend(step.to_le_bytes());
            for channel in channels {
                let origin = match channel {
                    NumberSystem::Grid { origin, .. } => *origin,
                    _ => 0.0,
                };
                out.extend(origin.to_le_bytes());
            }
        }
    }
}

/// Takes the system of directions off the front, if an attribute has it.
pub(super) fn take_octahedral(
    bytes: &mut &[u8],
    attribute: &Attribute,
) -> Result<Option<Octahedral>, FormatError> {
    if bytes.first() != Some(&OCTAHEDRAL) {
        return Ok(None);
    }
    byte(bytes)?;
    let bits = byte(bytes)?;
    if !(2..=24).contains(&bits)
        || attribute.component != Component::F32
        || attribute.components < 3
    {
        return Err(malformed("has an invalid quantisation grid"));
    }
    Ok(Some(Octahedral { bits }))
}

/// Takes the number systems of a stream off the front, one for each of its channels; nothing
/// without any.
pub(super) fn take(
    bytes: &mut &[u8],
    channels: usize,
    component: Component,
) -> Result<Vec<NumberSystem>, FormatError> {
    if channels == 0 {
        return Ok(Vec::new());
    }
    let wrong = || malformed("has an invalid quantisation grid");
    let system = match (byte(bytes)?, component) {
        (INTEGER, component) if component != Component::F32 => NumberSystem::Integer,
        (FLOAT, Component::F32) => NumberSystem::Float,
        (GRID, Component::F32) => {
            let step = float(bytes)?;
            let grid = |_| Ok(NumberSystem::Grid { origin: float(bytes)?, step });
            let grids = (0..channels).map(grid).collect::<Result<_, _>>()?;
            return if step > 0.0 { Ok(grids) } else { Err(wrong()) };
        }
        (n @ DECIMAL..=MAX_DECIMAL, Component::F32) => NumberSystem::Decimal(n - DECIMAL),
        (n @ MIN_SIGNIFICANT..=MAX_SIGNIFICANT, Component::F32) => {
            NumberSystem::Significant(n - SIGNIFICANT)
        }
        _ => return Err(wrong()),
    };
    Ok(vec![system; channels])
}

fn float(bytes: &mut &[u8]) -> Result<f32, FormatError> {
    let word = bytes.split_first_chunk();
    let (word, rest) = word.ok_or_else(|| malformed("is too short for its content"))?;
    *bytes = rest;
    Ok(f32::from_le_bytes(*word))
}
