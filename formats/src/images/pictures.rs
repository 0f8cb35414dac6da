//! The decoded images of one scene: each file is decoded once, and all together have a limited
//! number of pixels, beyond which they are scaled down.

use super::decode_if;
use crate::{Fault, FormatError, Limits};
use lodc_scene::Image;
use std::collections::BTreeMap;
use xxhash_rust::xxh3::xxh3_128;

/// Largest side of a picture in memory, in pixels; larger ones are scaled down. Chosen by hand: the
/// pictures that are drawn are smaller.
const MAX_KEPT_SIDE: u32 = 4096;
/// Pixels of all pictures in memory together: 1 GiB. Each may take a quarter of those that remain,
/// so that none gets nothing. Chosen by hand.
const MAX_KEPT_PIXELS: u64 = 1 << 28;

/// The pictures of one scene.
#[derive(Debug)]
pub(crate) struct Pictures {
    /// For each key that was asked for the index in `list`; none if the picture cannot be read.
    by_key: BTreeMap<String, Option<usize>>,
    /// The same by a hash of the file: many images of a document may be one.
    by_content: BTreeMap<u128, Result<usize, FormatError>>,
    pub(crate) list: Vec<Image>,
    pub(crate) warnings: Vec<String>,
    /// Pixels of `list`.
    pixels_kept: u64,
    /// Pixels that may be decoded.
    limit: u64,
    /// Pixels that may still be decoded.
    pixels_left: u64,
}

impl Pictures {
    /// No pictures yet, of an input with these limits.
    pub(crate) fn new(limits: &Limits) -> Self {
        Self {
            by_key: BTreeMap::new(),
            by_content: BTreeMap::new(),
            list: Vec::new(),
            warnings: Vec::new(),
            pixels_kept: 0,
            limit: limits.pixels,
            pixels_left: limits.pixels,
        }
    }

    /// The picture of this key, read if it has not been asked for before; none, with a warning, if
    /// it cannot be read. `name` is its name in messages.
    ///
    /// # Errors
    /// If the pictures together have more pixels than the limits allow.
    pub(crate) fn get(
        &mut self,
        key: &str,
        name: &str,
        read: impl FnOnce() -> Result<Vec<u8>, FormatError>,
    ) -> Result<Option<usize>, FormatError> {
        if let Some(index) = self.by_key.get(key) {
            return Ok(*index);
        }
        let index = match read() {
            Ok(bytes) => self.picture(&bytes, name)?,
            Err(e) => Err(e),
        };
        let index = index.map_err(|e| {
            self.warnings.push(format!("drawn without a texture: {}", e.in_file(name)));
        });
        self.by_key.insert(key.to_owned(), index.ok());
        Ok(index.ok())
    }

    /// The index of the picture in a file, or why there is none.
    ///
    /// # Errors
    /// As [`Pictures::get`].
    fn picture(
        &mut self,
        bytes: &[u8],
        name: &str,
    ) -> Result<Result<usize, FormatError>, FormatError> {
        let hash = xxh3_128(bytes);
        if let Some(index) = self.by_content.get(&hash) {
            return Ok(index.clone());
        }
        let (pixels_left, mut too_many) = (&mut self.pixels_left, false);
        let decoded = decode_if(bytes, |pixels| {
            let remaining = pixels_left.checked_sub(pixels).ok_or_else(|| {
                too_many = true;
                let problem = format!("more than {} pixels of images to decode", self.limit);
                FormatError::new(Fault::Limit, name, problem)
            });
            remaining.map(|remaining| *pixels_left = remaining)
        });
        let index = match decoded {
            Err(e) if too_many => return Err(e),
            Err(e) => Err(e),
            Ok(mut picture) => {
                picture.shrink(
                    MAX_KEPT_SIDE,
                    (MAX_KEPT_PIXELS - self.pixels_kept.min(MAX_KEPT_PIXELS)) / 4,
                );
                self.pixels_kept += u64::from(picture.width) * u64::from(picture.height);
                self.list.push(picture);
                Ok(self.list.len() - 1)
            }
        };
        self.by_content.insert(hash, index.clone());
        Ok(index)
    }
}
