//! Steps in few bits: one for each record, and mostly one byte for each triangle count.

use super::arrays;

/// Marks a number of lost triangles that stands behind the bytes in full.
const ESCAPE: u8 = u8::MAX;

/// One bit for each record, the lowest of a byte first: 1 if the next record belongs to the same step (the thesis's
/// `next_update`).
pub(super) fn joined(records: usize, step_ends: &[u32]) -> Vec<u8> {
    let mut bits = vec![0xff; records / 8];
    if !records.is_multiple_of(8) {
        bits.push((1 << (records % 8)) - 1);
    }
    for &end in step_ends {
        let last = end as usize - 1;
        bits[last / 8] &= !(1 << (last % 8));
    }
    bits
}

/// The LODs after the steps.
pub(super) fn step_ends(bits: &[u8], records: usize) -> Result<Vec<u32>, String> {
    if bits.len() != records.div_ceil(8) {
        return Err(format!("{} bytes are not one bit for each of {records} records", bits.len()));
    }
    let joined = |k: usize| bits[k / 8] >> (k % 8) & 1 == 1;
    if (records..8 * bits.len()).any(joined) {
        return Err("bits behind the last record are set".to_owned());
    }
    if records > 0 && joined(records - 1) {
        return Err("the last record is joined to one that is not there".to_owned());
    }
    Ok((0..records).filter(|&k| !joined(k)).map(|k| k as u32 + 1).collect())
}

/// How many triangles each step loses: a byte each, 255 standing for a number that follows behind all the bytes.
pub(super) fn lost_triangles(triangles: u32, step_triangles: &[u32]) -> Vec<u8> {
    let mut before = triangles;
    let lost: Vec<u32> = step_triangles.iter().map(|&after| std::mem::replace(&mut before, after) - after).collect();
    let mut bytes: Vec<u8> = lost.iter().map(|&n| n.min(u32::from(ESCAPE)) as u8).collect();
    let many: Vec<u32> = lost.into_iter().filter(|&n| n >= u32::from(ESCAPE)).collect();
    arrays::put_u32s(&mut bytes, &many);
    bytes
}

/// The live triangles after each step.
pub(super) fn step_triangles(bytes: &[u8], steps: usize, triangles: u32) -> Result<Vec<u32>, String> {
    let Some((short, long)) = bytes.split_at_checked(steps) else {
        return Err(format!("{} bytes are not one for each of {steps} steps", bytes.len()));
    };
    let escapes = short.iter().filter(|&&b| b == ESCAPE).count();
    if long.len() != 4 * escapes {
        return Err(format!("{} bytes follow where {escapes} long numbers should", long.len()));
    }
    let mut long = long.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    let mut left = triangles;
    let mut after = Vec::with_capacity(steps);
    for (step, &byte) in short.iter().enumerate() {
        let lost = if byte == ESCAPE { long.next().unwrap_or_default() } else { u32::from(byte) };
        if byte == ESCAPE && lost < u32::from(ESCAPE) {
            return Err(format!("step {step} says {lost} in five bytes, which is not the shortest way"));
        }
        left = left.checked_sub(lost).ok_or_else(|| format!("step {step} loses {lost} of {left} triangles"))?;
        after.push(left);
    }
    // The last LOD is one vertex.
    if left != 0 {
        return Err(format!("the last step leaves {left} triangles"));
    }
    Ok(after)
}
