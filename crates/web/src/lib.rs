//! Levels of `.lodc` files and `.lods` streams for a browser: bytes in, GLB out.
//!
//! Everything is a number or bytes, so that `wasm/` can offer it without knowing any type: a host
//! writes bytes into an input and reads them from an output. [`Sessions`] keeps what is open.
//!
//! ```
//! use lodc_web::{Sessions, Status};
//!
//! let file = std::fs::read("../../fixtures/golden/v1/triangle.lodc")?;
//! let mut sessions = Sessions::new();
//! let number = sessions.open();
//! let session = sessions.get(number).expect("it was just opened");
//! session.input(file.len()).copy_from_slice(&file);
//! assert_eq!(session.open(), Status::Done);
//! assert!(session.output().starts_with(b"glTF"));
//! # Ok::<(), std::io::Error>(())
//! ```

mod decoder;
#[cfg(feature = "full")]
mod levels;
#[cfg(feature = "full")]
mod modules;
#[cfg(feature = "full")]
mod session;

pub use decoder::Decoder;
#[cfg(feature = "full")]
pub use levels::levels;
#[cfg(feature = "full")]
pub use modules::MODULES;
#[cfg(feature = "full")]
pub use session::Session;

/// Result of a call; the output holds what it says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The output is the result.
    Done = 0,
    /// The output is a line that says what is wrong.
    Failed = 1,
}

#[cfg(feature = "full")]
/// Everything that a host has open, by number.
#[derive(Debug, Default)]
pub struct Sessions(Vec<Option<Session>>);

#[cfg(feature = "full")]
impl Sessions {
    /// Nothing is open.
    #[must_use]
    pub const fn new() -> Self {
        Self(Vec::new())
    }
    /// Opens a session; its number is the smallest that is free.
    pub fn open(&mut self) -> u32 {
        let free = self.0.iter().position(Option::is_none).unwrap_or(self.0.len());
        if free == self.0.len() {
            self.0.push(None);
        }
        self.0[free] = Some(Session::default());
        free as u32
    }
    /// The session of a number, if it is open.
    pub fn get(&mut self, number: u32) -> Option<&mut Session> {
        self.0.get_mut(number as usize)?.as_mut()
    }
    /// Closes a session and frees its memory.
    pub fn close(&mut self, number: u32) {
        if let Some(session) = self.0.get_mut(number as usize) {
            *session = None;
        }
    }
}

#[cfg(all(test, feature = "full"))]
mod tests;
