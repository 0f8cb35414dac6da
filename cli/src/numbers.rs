//! Whole numbers as values of options.

use std::ops::{Bound, RangeBounds};
use std::str::FromStr;

/// Returns a parser of whole numbers in a range.
pub(crate) fn whole<N: FromStr>(
    range: impl RangeBounds<i128> + Clone + Send + Sync + 'static,
) -> impl Fn(&str) -> Result<N, String> + Clone + Send + Sync + 'static {
    move |text| {
        let number: i128 = text.parse().map_err(|_| "must be a whole number".to_owned())?;
        let in_range = range.contains(&number).then(|| text.parse().ok()).flatten();
        in_range.ok_or_else(|| match (range.start_bound(), range.end_bound()) {
            (Bound::Included(low), Bound::Included(high)) => {
                format!("must be from {low} to {high}")
            }
            (Bound::Included(low), _) if number < *low => format!("must be at least {low}"),
            _ => "is too large".to_owned(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::num::NonZeroU32;

    #[test]
    fn whole_numbers_are_read_and_others_are_told_the_range() {
        let why = |text: &str| whole::<NonZeroU32>(1..)(text).map(NonZeroU32::get);
        assert_eq!(why("7"), Ok(7));
        for (wrong, expected) in [
            ("0", "must be at least 1"),
            ("-1", "must be at least 1"),
            ("1.5", "must be a whole number"),
            ("1k", "must be a whole number"),
            ("", "must be a whole number"),
            ("5000000000", "is too large"),
        ] {
            assert_eq!(why(wrong), Err(expected.to_owned()), "{wrong}");
        }
        let poses = whole::<u8>(0..=64);
        assert_eq!((poses("0"), poses("64")), (Ok(0), Ok(64)));
        assert_eq!(poses("99"), Err("must be from 0 to 64".to_owned()));
    }
}
