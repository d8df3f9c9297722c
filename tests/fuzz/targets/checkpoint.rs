#![no_main]
libfuzzer_sys::fuzz_target!(|bytes: &[u8]| -> libfuzzer_sys::Corpus { torquescope_fuzz::document(torquescope_fuzz::Kind::Checkpoint, bytes) });
