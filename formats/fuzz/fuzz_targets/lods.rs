//! Any bytes as a `.lods` stream, in pieces of any length: meshes can be asked for at any time.
//! Every input is also tried with valid checksums, to reach the code behind them.

#![no_main]

use libfuzzer_sys::fuzz_target;
use lodc_formats::Limits;
use lodc_formats::lods::{Unpacker, with_valid_checksums};

fuzz_target!(|bytes: &[u8]| {
    let Some((&piece, bytes)) = bytes.split_first() else { return };
    for stream in [bytes.to_vec(), with_valid_checksums(bytes)] {
        let limits = Limits { vertices: 1 << 20, triangles: 1 << 20, ..Limits::DEFAULT };
        let mut unpacker = Unpacker::new(limits);
        for piece in stream.chunks(1 + usize::from(piece)) {
            if unpacker.feed(piece).is_err() {
                break;
            }
        }
        for object in 0..unpacker.objects() {
            let _ = unpacker.mesh(object);
            let _ = unpacker.progress(object);
            if unpacker.is_complete() {
                let _ = unpacker.rebuilt(object);
            }
        }
    }
});
