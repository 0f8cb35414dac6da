//! What the loader of the npm package runs: bytes of a file or stream in, typed arrays out, as far
//! as the bytes go.
//!
//! The output is a message of chunks (`message.rs`), which `loader/message.js` reads. Vertices are
//! in stream order, those of files too: the vertices of a coarse level come first, so that arrays
//! only grow.

#[cfg(feature = "file")]
mod file;
mod levels;
mod message;
#[cfg(feature = "stream")]
mod stream;

use crate::Status;
use lodc_formats::FormatError;
use message::Message;
#[cfg(feature = "stream")]
use stream::StreamReader;

/// A `.lodc` file, or a `.lods` stream that is fed piece by piece.
#[derive(Debug, Default)]
pub struct Decoder {
    input: Vec<u8>,
    output: Vec<u8>,
    #[cfg(feature = "stream")]
    stream: Option<Box<StreamReader>>,
}

impl Decoder {
    /// Room for the next input of `length` bytes.
    pub fn input(&mut self, length: usize) -> &mut [u8] {
        self.input.clear();
        self.input.resize(length, 0);
        &mut self.input
    }

    /// The result of the last call.
    #[must_use]
    pub fn output(&self) -> &[u8] {
        &self.output
    }

    /// Takes the input as a whole `.lodc` file. The output is a message with all of it.
    #[cfg(feature = "file")]
    pub fn open(&mut self) -> Status {
        let input = std::mem::take(&mut self.input);
        self.answer(file::message(&input))
    }

    /// Takes the input as the next bytes of a `.lods` stream. The output is empty.
    #[cfg(feature = "stream")]
    pub fn feed(&mut self) -> Status {
        let stream = self.stream.get_or_insert_default();
        let fed = stream.feed(&self.input);
        self.answer(fed.map(|()| Message::default()))
    }

    /// The output is a message with everything of the stream that no message had so far.
    #[cfg(feature = "stream")]
    pub fn grown(&mut self) -> Status {
        let message = self.stream.as_mut().map(|stream| stream.message());
        self.answer(Ok(message.unwrap_or_default()))
    }

    fn answer(&mut self, result: Result<Message, FormatError>) -> Status {
        let (output, status) = match result {
            Ok(message) => (message.bytes, Status::Done),
            // Not by `Display`, whose escapes would be a tenth of the decoder.
            Err(e) => ([e.location, e.problem].join(": ").into_bytes(), Status::Failed),
        };
        self.output = output;
        status
    }
}
