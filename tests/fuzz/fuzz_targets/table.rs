//! `table`, guided by coverage.
#![no_main]
libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = rusty_tests::fuzz::target("table").check(bytes);
});
