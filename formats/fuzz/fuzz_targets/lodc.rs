//! Bytes as a `.lodc` file: what can be read can be replayed and written again. Every input is also
//! tried with valid checksums, to reach the code behind them.

#![no_main]

use libfuzzer_sys::fuzz_target;
use lodc::{read, write};
use lodc_formats::lodc::with_valid_checksums;
use lodc_mesh::Lod;
use lodc_model::Model;

fuzz_target!(|bytes: &[u8]| {
    for bytes in [bytes.to_vec(), with_valid_checksums(bytes)] {
        let Ok(file) = read(&bytes) else { continue };
        for object in &file.objects {
            let last = object.simplified.collapses().last();
            for model in &object.models {
                let mut cursor = model.cursor();
                for lod in [last, Lod(last.0 / 2), Lod(0)] {
                    model.seek(&mut cursor, lod, &mut ());
                    let _ = object.simplified.mesh().extract(&model.triangles(&cursor));
                }
            }
        }
        let again = write(&file);
        assert!(read(&again).is_ok(), "what was read is written as something else");
    }
});
