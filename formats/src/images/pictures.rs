//! Pictures as they are asked for: each read once, all together bounded.

use super::decode;
use crate::FormatError;
use lodc_scene::Image;

/// Longest side that is kept.
const SIDE: u32 = 4096;
/// Pixels kept in all; each picture may take a quarter of what is left, so that none gets nothing.
const PIXELS: u64 = 1 << 28;

/// The pictures of one scene.
#[derive(Debug, Default)]
pub(crate) struct Pictures {
    /// By the key they were asked for with: where they are, or nowhere.
    known: Vec<(String, Option<usize>)>,
    pub(crate) list: Vec<Image>,
    pub(crate) warnings: Vec<String>,
    taken: u64,
}

impl Pictures {
    /// The picture of this key, read if it has not been asked for before. `name` is what a warning
    /// calls it.
    pub(crate) fn get(
        &mut self,
        key: &str,
        name: &str,
        read: impl FnOnce() -> Result<Vec<u8>, FormatError>,
    ) -> Option<usize> {
        if let Some((_, known)) = self.known.iter().find(|(k, _)| k == key) {
            return *known;
        }
        let found = match read().and_then(|bytes| decode(&bytes)) {
            Ok(mut picture) => {
                picture.shrink(SIDE, (PIXELS - self.taken.min(PIXELS)) / 4);
                self.taken += u64::from(picture.width) * u64::from(picture.height);
                self.list.push(picture);
                Some(self.list.len() - 1)
            }
            Err(e) => {
                self.warnings.push(format!("drawn without a texture: {}", e.in_file(name)));
                None
            }
        };
        self.known.push((key.to_owned(), found));
        found
    }
}
