//! The decoded images of one scene: each file is decoded once, and all together have a limited
//! number of pixels, beyond which they are scaled down.

use super::decode_if;
use crate::{Fault, FormatError, Limits};
use lodc_scene::Image;
use std::collections::BTreeMap;
use xxhash_rust::xxh3::xxh3_128;

/// Longest side that is kept.
const SIDE: u32 = 4096;
/// Pixels kept in all; each picture may take a quarter of what is left, so that none gets nothing.
const PIXELS: u64 = 1 << 28;

/// The pictures of one scene.
#[derive(Debug)]
pub(crate) struct Pictures {
    /// By the key they were asked for with: where they are, or nowhere.
    known: BTreeMap<String, Option<usize>>,
    /// By a hash of their files: many images of a document may be one.
    decoded: BTreeMap<u128, Result<usize, FormatError>>,
    pub(crate) list: Vec<Image>,
    pub(crate) warnings: Vec<String>,
    pixels_kept: u64,
    /// Pixels that may be decoded, and those of them that are left.
    limit: u64,
    pixels_left: u64,
}

impl Pictures {
    /// No pictures yet, of an input with these limits.
    pub(crate) fn new(limits: &Limits) -> Self {
        Self {
            known: BTreeMap::new(),
            decoded: BTreeMap::new(),
            list: Vec::new(),
            warnings: Vec::new(),
            pixels_kept: 0,
            limit: limits.pixels,
            pixels_left: limits.pixels,
        }
    }

    /// The picture of this key, read if it has not been asked for before; none, with a warning, if
    /// it cannot be had. `name` is what messages call it.
    ///
    /// # Errors
    /// If the pictures together have more pixels than the limits allow.
    pub(crate) fn get(
        &mut self,
        key: &str,
        name: &str,
        read: impl FnOnce() -> Result<Vec<u8>, FormatError>,
    ) -> Result<Option<usize>, FormatError> {
        if let Some(known) = self.known.get(key) {
            return Ok(*known);
        }
        let decoded_image = match read() {
            Ok(bytes) => self.picture(&bytes, name)?,
            Err(e) => Err(e),
        };
        let decoded_image = decoded_image.map_err(|e| {
            self.warnings.push(format!("drawn without a texture: {}", e.in_file(name)));
        });
        self.known.insert(key.to_owned(), decoded_image.ok());
        Ok(decoded_image.ok())
    }

    /// The picture in a file, or why there is none.
    ///
    /// # Errors
    /// As [`Pictures::get`].
    fn picture(
        &mut self,
        bytes: &[u8],
        name: &str,
    ) -> Result<Result<usize, FormatError>, FormatError> {
        let hash = xxh3_128(bytes);
        if let Some(known) = self.decoded.get(&hash) {
            return Ok(known.clone());
        }
        let (pixels_left, mut too_many) = (&mut self.pixels_left, false);
        let decoded = decode_if(bytes, |pixels| {
            let after_this = pixels_left.checked_sub(pixels).ok_or_else(|| {
                too_many = true;
                let problem = format!("more than {} pixels of images to decode", self.limit);
                FormatError::new(Fault::Limit, name, problem)
            });
            after_this.map(|after_this| *pixels_left = after_this)
        });
        let decoded_image = match decoded {
            Err(e) if too_many => return Err(e),
            Err(e) => Err(e),
            Ok(mut picture) => {
                picture.shrink(SIDE, (PIXELS - self.pixels_kept.min(PIXELS)) / 4);
                self.pixels_kept += u64::from(picture.width) * u64::from(picture.height);
                self.list.push(picture);
                Ok(self.list.len() - 1)
            }
        };
        self.decoded.insert(hash, decoded_image.clone());
        Ok(decoded_image)
    }
}
