//! Bytes on their way from the guard to tobj: in blocks, from one thread to the other, so that the
//! cleaned text is never in memory as a whole.

use std::io::{self, BufRead, Read};
use std::sync::mpsc::{Receiver, SyncSender};

const BLOCK: usize = 64 << 10;

/// The writing end.
pub(super) struct Blocks {
    pub(super) text: Vec<u8>,
    sender: SyncSender<Vec<u8>>,
}

impl Blocks {
    /// An empty text for `sender`.
    pub(super) fn new(sender: SyncSender<Vec<u8>>) -> Self {
        Self { text: Vec::with_capacity(2 * BLOCK), sender }
    }

    /// Passes the text on once there is enough of it; called between lines.
    pub(super) fn pass(&mut self, least: usize) {
        if self.text.len() >= least.clamp(1, BLOCK) {
            // A reader that is gone has an error of its own.
            let block = std::mem::replace(&mut self.text, Vec::with_capacity(2 * BLOCK));
            let _ = self.sender.send(block);
        }
    }

    /// Appends a decimal number.
    pub(super) fn decimal(&mut self, number: u32) {
        let mut digits = [0; 10];
        let (mut at, mut rest) = (digits.len(), number);
        loop {
            at -= 1;
            digits[at] = b'0' + (rest % 10) as u8;
            rest /= 10;
            if rest == 0 {
                break;
            }
        }
        self.text.extend_from_slice(&digits[at..]);
    }
}

/// The reading end.
pub(super) struct Feed {
    receiver: Receiver<Vec<u8>>,
    block: Vec<u8>,
    at: usize,
}

impl Feed {
    /// Reads what comes from `receiver`.
    pub(super) fn new(receiver: Receiver<Vec<u8>>) -> Self {
        Self { receiver, block: Vec::new(), at: 0 }
    }
}

impl Read for Feed {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.fill_buf()?.read(buffer)?;
        self.consume(count);
        Ok(count)
    }
}

impl BufRead for Feed {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.at == self.block.len() {
            self.at = 0;
            // The end of the text is that nobody can send any more.
            self.block = self.receiver.recv().unwrap_or_default();
        }
        Ok(&self.block[self.at..])
    }

    fn consume(&mut self, count: usize) {
        self.at += count;
    }
}
