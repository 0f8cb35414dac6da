//! Bytes as an `.stl` file.

#![no_main]

mod import;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| import::import_and_export(bytes, "stl"));
