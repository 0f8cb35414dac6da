//! Bytes as a `.lods` stream: whatever comes, in whatever pieces, can be looked at. Checksums are
//! made right on the way, so that what lies behind them is tested too.

#![no_main]

use libfuzzer_sys::fuzz_target;
use lodc_formats::Limits;
use lodc_formats::lods::{Unpacker, repaired};

fuzz_target!(|bytes: &[u8]| {
    let Some((&piece, bytes)) = bytes.split_first() else { return };
    for stream in [bytes.to_vec(), repaired(bytes)] {
        let mut unpacker = Unpacker::new(Limits { vertices: 1 << 20, triangles: 1 << 20, ..Limits::DEFAULT });
        for piece in stream.chunks(1 + usize::from(piece)) {
            if unpacker.feed(piece).is_err() {
                break;
            }
        }
        for object in 0..unpacker.objects() {
            let _ = unpacker.mesh(object);
            let _ = unpacker.strips(object);
            let _ = unpacker.state(object);
        }
    }
});
