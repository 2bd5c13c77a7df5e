//! The target with the name of this program, guided by coverage.
#![no_main]
libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = rusty_tests::fuzz::target(env!("CARGO_BIN_NAME")).check(bytes);
});
