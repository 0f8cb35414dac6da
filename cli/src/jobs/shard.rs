//! Shards of a run for several machines: disjoint, together complete, and an asset stays in its
//! shard when others are added.

use lodc_formats::lodc::key;
use std::str::FromStr;

/// Shard `index` of `count`; `index` counts from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Shard {
    index: u64,
    count: u64,
}

impl Shard {
    /// Reads `I/N`.
    ///
    /// # Errors
    /// Unless 1 ≤ I ≤ N.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        let number = |part: &str| u64::from_str(part).ok();
        let numbers = text.split_once('/').and_then(|(i, n)| Some((number(i)?, number(n)?)));
        match numbers {
            Some((index, count)) if (1..=count).contains(&index) => Ok(Self { index, count }),
            _ => {
                Err("a shard and the number of shards, such as 1/4 (shards count from 1)"
                    .to_owned())
            }
        }
    }

    /// Returns whether an asset of this name belongs to the shard: the XXH3-128 of the name, modulo
    /// `count`, decides.
    #[must_use]
    pub(crate) fn contains(self, name: &str) -> bool {
        key(name.as_bytes()) % u128::from(self.count) == u128::from(self.index - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_are_disjoint_and_complete() {
        let names: Vec<String> = (0..500).map(|i| format!("props/{i}.obj")).collect();
        for count in [1, 2, 7] {
            let shards: Vec<Shard> = (1..=count)
                .map(|i| Shard::parse(&format!("{i}/{count}")).expect("a shard"))
                .collect();
            for name in &names {
                assert_eq!(shards.iter().filter(|shard| shard.contains(name)).count(), 1, "{name}");
            }
            let first = names.iter().filter(|name| shards[0].contains(name)).count() as u64;
            assert!((400 / count..=600 / count).contains(&first), "{first} of {count}");
        }
    }

    #[test]
    fn malformed_shards_are_refused() {
        for wrong in ["", "1", "0/2", "3/2", "1/0", "a/b", "1/2/3", "-1/2"] {
            assert!(Shard::parse(wrong).is_err(), "{wrong}");
        }
    }
}
