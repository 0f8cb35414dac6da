//! Compact encodings of steps: which records form one (a bit for each record), how many triangles
//! each removes (mostly a byte), and by how much its errors grow (LEB128).

use super::arrays;
use lodc_mesh::put_leb128;

/// Marks a number of lost triangles that follows the bytes in full.
const ESCAPE: u8 = u8::MAX;

/// One bit for each record, the lowest of a byte first: 1 if the next record belongs to the same
/// step (the thesis's `next_update`).
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

/// Number of triangles each step loses: a byte each, 255 for a number that follows
/// all the bytes.
pub(super) fn lost_triangles(triangles: u32, step_triangles: &[u32]) -> Vec<u8> {
    let mut before = triangles;
    let lost: Vec<u32> = step_triangles
        .iter()
        .map(|&triangles_after| std::mem::replace(&mut before, triangles_after) - triangles_after)
        .collect();
    let mut bytes: Vec<u8> = lost.iter().map(|&n| n.min(u32::from(ESCAPE)) as u8).collect();
    let long: Vec<u32> = lost.into_iter().filter(|&n| n >= u32::from(ESCAPE)).collect();
    arrays::put_u32s(&mut bytes, &long);
    bytes
}

/// The live triangles after each step.
pub(super) fn step_triangles(
    bytes: &[u8],
    steps: usize,
    triangles: u32,
) -> Result<Vec<u32>, String> {
    let Some((short, long)) = bytes.split_at_checked(steps) else {
        return Err(format!("{} bytes are not one for each of {steps} steps", bytes.len()));
    };
    let escapes = short.iter().filter(|&&b| b == ESCAPE).count();
    if long.len() != 4 * escapes {
        return Err(format!("{} bytes follow where {escapes} long numbers should", long.len()));
    }
    let mut long = long.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    let mut triangles_left = triangles;
    let mut triangles_after = Vec::with_capacity(steps);
    for (step, &byte) in short.iter().enumerate() {
        let lost = if byte == ESCAPE { long.next().unwrap_or_default() } else { u32::from(byte) };
        if byte == ESCAPE && lost < u32::from(ESCAPE) {
            return Err(format!(
                "step {step} says {lost} in five bytes, which is not the shortest way"
            ));
        }
        triangles_left = triangles_left
            .checked_sub(lost)
            .ok_or_else(|| format!("step {step} loses {lost} of {triangles_left} triangles"))?;
        triangles_after.push(triangles_left);
    }
    // The last LOD is one vertex.
    if triangles_left != 0 {
        return Err(format!("the last step leaves {triangles_left} triangles"));
    }
    Ok(triangles_after)
}

/// The errors after the steps, which never fall, as differences of their bits from step to step:
/// LEB128, that is seven bits a byte, the lowest first, all bytes but a number's last with their
/// top bit set.
pub(super) fn error_growth(step_errors: &[f32]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(2 * step_errors.len());
    let mut before = 0;
    for error in step_errors {
        // Adding zero makes 0 of −0, the only error whose bits would not grow.
        let bits = (error + 0.0).to_bits();
        put_leb128(&mut bytes, u64::from(bits - std::mem::replace(&mut before, bits)));
    }
    bytes
}

/// The errors that [`error_growth`] has encoded.
pub(super) fn step_errors(bytes: &[u8], steps: usize) -> Result<Vec<f32>, String> {
    if bytes.len() < steps {
        return Err(format!("{} bytes are too few for {steps} steps", bytes.len()));
    }
    let (mut bits, mut growth, mut shift) = (0u32, 0u64, 0);
    let mut errors = Vec::with_capacity(steps);
    for &byte in bytes {
        growth |= u64::from(byte & 0x7f) << shift;
        if byte >= 0x80 {
            shift += 7;
            if shift > 28 {
                return Err(format!("step {} has a number of more than five bytes", errors.len()));
            }
            continue;
        }
        if byte == 0 && shift > 0 {
            return Err(format!(
                "step {} has a number that is not written in the shortest way",
                errors.len()
            ));
        }
        let grown = u32::try_from(growth).ok().and_then(|growth| bits.checked_add(growth));
        bits =
            grown.ok_or_else(|| format!("the error of step {} is out of range", errors.len()))?;
        errors.push(f32::from_bits(bits));
        (growth, shift) = (0, 0);
    }
    if shift > 0 || errors.len() != steps {
        return Err(format!("{} errors are not one for each of {steps} steps", errors.len()));
    }
    Ok(errors)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_come_back_bit_for_bit_and_other_spellings_are_refused() {
        let errors =
            [0.0, 0.0, f32::MIN_POSITIVE / 4.0, 1e-20, 0.5, 0.5, 0.500_000_06, 3e7, f32::MAX];
        let bytes = error_growth(&errors);
        let again = step_errors(&bytes, errors.len()).expect("what was written");
        assert!(again.iter().zip(&errors).all(|(a, b)| a.to_bits() == b.to_bits()));
        assert_eq!(error_growth(&[-0.0, 1.0]), error_growth(&[0.0, 1.0]));
        for cut in 0..bytes.len() {
            assert!(step_errors(&bytes[..cut], errors.len()).is_err());
        }
        for (wrong, steps) in [
            (&[0x80, 0][..], 1),
            (&[0xff, 0xff, 0xff, 0xff, 0x10], 1),
            (&[0xff, 0xff, 0xff, 0xff, 0xff, 1], 1),
            (&[0xff, 0xff, 0xff, 0xff, 0x0f, 1], 2),
            (&[1, 1], 1),
        ] {
            assert!(step_errors(wrong, steps).is_err(), "{wrong:?}");
        }
    }
}
