//! The number systems of an object's streams.

use super::{byte, malformed};
use crate::FormatError;
use lodc_mesh::{Attribute, Component};
use lodc_progressive::{NumberSystem, VertexLayout};
use serde::Deserialize;

const FLOAT: u8 = 0;
const INTEGER: u8 = 1;
const GRID: u8 = 2;
/// Plus the number of digits.
const DECIMAL: u8 = 16;
const SIGNIFICANT: u8 = 32;

/// The number system of a stream as it is stored, valid or not.
#[derive(Deserialize)]
pub(in crate::lods) enum SystemEntry {
    Float,
    Decimal(u8),
    Significant(u8),
    Integer,
    Grid { origins: Vec<f32>, step: f32 },
}

/// Appends the system of a stream with these channels.
pub(super) fn put(out: &mut Vec<u8>, channels: &[NumberSystem]) {
    match channels[0] {
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

/// Takes the system of a stream with so many channels off the front.
pub(super) fn take(bytes: &mut &[u8], channels: usize) -> Result<SystemEntry, FormatError> {
    let float = |bytes: &mut &[u8]| -> Result<f32, FormatError> {
        let (four, rest) = bytes
            .split_first_chunk()
            .ok_or_else(|| malformed("is too short for what it should hold"))?;
        *bytes = rest;
        Ok(f32::from_le_bytes(*four))
    };
    match byte(bytes)? {
        FLOAT => Ok(SystemEntry::Float),
        INTEGER => Ok(SystemEntry::Integer),
        GRID => {
            let step = float(bytes)?;
            let origins = (0..channels).map(|_| float(bytes)).collect::<Result<_, _>>()?;
            Ok(SystemEntry::Grid { origins, step })
        }
        n @ DECIMAL..SIGNIFICANT => Ok(SystemEntry::Decimal(n - DECIMAL)),
        n @ SIGNIFICANT.. => Ok(SystemEntry::Significant(n - SIGNIFICANT)),
        _ => Err(malformed("has a system of numbers that is not known")),
    }
}

/// Returns the layout of a vertex; `None` if a stream cannot have its system.
pub(in crate::lods) fn vertex_layout(
    entries: Vec<SystemEntry>,
    attributes: &[Attribute],
) -> Option<VertexLayout> {
    let streams = VertexLayout::streams(attributes);
    let components = std::iter::once(Component::F32).chain(attributes.iter().map(|a| a.component));
    let mut systems = Vec::new();
    if entries.len() != streams.len() {
        return None;
    }
    for ((stream, component), entry) in streams.iter().zip(components).zip(entries) {
        systems.extend(channel_systems(entry, stream.channels, component)?);
    }
    Some(VertexLayout { systems, streams })
}

/// Returns the systems of a stream's channels; `None` if there is no such system.
fn channel_systems(
    entry: SystemEntry,
    channels: usize,
    component: Component,
) -> Option<Vec<NumberSystem>> {
    let system = match entry {
        SystemEntry::Float => NumberSystem::Float,
        SystemEntry::Decimal(n @ 0..=9) => NumberSystem::Decimal(n),
        SystemEntry::Significant(n @ 1..=7) => NumberSystem::Significant(n),
        SystemEntry::Integer => NumberSystem::Integer,
        SystemEntry::Grid { origins, step }
            if component == Component::F32 && origins.len() == channels && step > 0.0 =>
        {
            let grid = |origin| NumberSystem::Grid { origin, step };
            return Some(origins.into_iter().map(grid).collect());
        }
        _ => return None,
    };
    let is_integer = matches!(system, NumberSystem::Integer);
    (is_integer != (component == Component::F32)).then(|| vec![system; channels])
}
