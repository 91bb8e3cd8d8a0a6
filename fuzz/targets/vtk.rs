//! Any bytes as a mesh of VTK.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| estar_fuzz::read_and_write_mesh(bytes));
