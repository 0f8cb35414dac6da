//! The optional section `POSE`: animated poses for which an object's errors hold besides the one at
//! rest.

use super::arrays::check_whole_entries;
use super::table::{location, tag};
use crate::{Fault, FormatError};
use lodc_mesh::PoseKey;

/// Bytes of a pose: its kind, its number, its seconds.
const POSE_BYTES: usize = 16;

/// Kind of a pose that is a moment of an animation, whose number it has.
const MOMENT: u32 = 0;
/// Kind of a pose that is a morph target at full weight, whose number it has.
const TARGET: u32 = 1;

/// Largest number of poses of an object. Chosen by hand: errors are measured in each.
pub const MAX_POSES: usize = 64;

pub(super) fn put(out: &mut Vec<u8>, poses: &[PoseKey]) {
    for &pose in poses {
        let (kind, number, seconds) = match pose {
            PoseKey::Moment { animation, seconds } => (MOMENT, animation, seconds),
            PoseKey::Target(target) => (TARGET, target, 0.0),
        };
        out.extend(kind.to_le_bytes());
        out.extend(number.to_le_bytes());
        out.extend(seconds.to_le_bytes());
    }
}

/// Reads the section of an object; nothing is no pose.
pub(super) fn get(bytes: &[u8], number: u32) -> Result<Vec<PoseKey>, FormatError> {
    let location = || location(tag::POSES, number, 0);
    let wrong = |problem: String| FormatError::new(Fault::Malformed, location(), problem);
    check_whole_entries(bytes, POSE_BYTES, location)?;
    if bytes.len() / POSE_BYTES > MAX_POSES {
        return Err(wrong(format!("has more than {MAX_POSES} poses")));
    }
    let pose = |entry: &[u8]| {
        let word = |offset: usize| u32::from_le_bytes(std::array::from_fn(|i| entry[offset + i]));
        let seconds = f64::from_le_bytes(std::array::from_fn(|i| entry[8 + i]));
        match (word(0), word(4)) {
            (MOMENT, animation) if seconds.is_finite() && seconds >= 0.0 => {
                Ok(PoseKey::Moment { animation, seconds })
            }
            (TARGET, target) if seconds.to_bits() == 0 => Ok(PoseKey::Target(target)),
            (kind, _) => Err(wrong(format!("has a pose of kind {kind} at {seconds} s"))),
        }
    };
    bytes.chunks_exact(POSE_BYTES).map(pose).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn poses_come_back_and_nonsense_is_refused() {
        let poses = [PoseKey::Moment { animation: 3, seconds: 1.25 }, PoseKey::Target(7)];
        let mut bytes = Vec::new();
        put(&mut bytes, &poses);
        assert_eq!(get(&bytes, 0), Ok(poses.to_vec()));
        for (at, byte) in [(0, 2), (0, 1), (15, 0xff), (31, 1)] {
            let mut wrong = bytes.clone();
            wrong[at] = byte;
            assert!(get(&wrong, 0).is_err(), "{at}");
        }
        assert!(get(&bytes[1..], 0).is_err());
        assert!(get(&bytes.repeat(MAX_POSES / 2), 0).is_ok());
        assert!(get(&bytes.repeat(MAX_POSES / 2 + 1), 0).is_err());
    }
}
