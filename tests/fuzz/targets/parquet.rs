#![no_main]
libfuzzer_sys::fuzz_target!(|bytes: &[u8]| -> libfuzzer_sys::Corpus { torquescope_fuzz::log(torquescope_fuzz::Format::Parquet, bytes) });
