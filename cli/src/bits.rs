//! Parses quantisation bits by kind of value, such as `pos=16,normal=10`.

use std::ops::RangeInclusive;

/// Parses a list such as `pos=16,normal=10`; returns the bits of each of `kinds`.
///
/// # Errors
/// If a kind is unknown or given twice, or its bits are out of range.
pub(crate) fn bits_by_kind<const N: usize>(
    text: &str,
    kinds: [&str; N],
    range: &RangeInclusive<u8>,
) -> Result<[Option<u8>; N], String> {
    let mut all = [None; N];
    for part in text.split(',') {
        let (kind, bits) =
            part.split_once('=').ok_or_else(|| format!("\"{part}\" is not KIND=BITS"))?;
        let bits = bits.parse::<u8>().ok().filter(|b| range.contains(b));
        let (fewest, most) = range.clone().into_inner();
        let bits = bits
            .ok_or_else(|| format!("\"{part}\": bits must be a number from {fewest} to {most}"))?;
        let Some(index) = kinds.iter().position(|k| *k == kind) else {
            return Err(format!("\"{kind}\" is not one of {}", kinds.join(", ")));
        };
        if all[index].replace(bits).is_some() {
            return Err(format!("\"{kind}\" is given twice"));
        }
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_asked_for_by_kind() {
        let parse = |text: &str| bits_by_kind(text, ["pos", "normal", "uv"], &(2..=24));
        assert_eq!(parse("pos=16,normal=10,uv=12"), Ok([Some(16), Some(10), Some(12)]));
        assert_eq!(parse("uv=2"), Ok([None, None, Some(2)]));
        for wrong in
            ["", "pos", "pos=", "pos=1", "pos=25", "pos=16,pos=16", "color=8", "pos=16,", "pos=-3"]
        {
            assert!(parse(wrong).is_err(), "{wrong}");
        }
    }
}
