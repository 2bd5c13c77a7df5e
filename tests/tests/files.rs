//! Files that are damaged, too large, or not files.

use std::fs;

use rusty_tests::*;

#[test]
fn a_damaged_table_is_refused_without_a_panic() {
    let place = folder();
    let path = place.path().join("t.parquet");
    let table = path.to_str().unwrap();
    let sweep = ["sweep", "patrol", "--ticks", "20", "--seeds", "0..3", "--quiet", "--out", table];
    sim_server(&sweep).expect(0);
    let file = fs::read(&path).unwrap();
    let end = file.len() - 8;
    let footer = end - u32::from_le_bytes(file[end..end + 4].try_into().unwrap()) as usize;
    let mut refused = 0;
    // Here the footer describes the columns' places.
    for at in (footer + 400..footer + 520).step_by(2) {
        for mask in [0x01, 0x80] {
            let mut changed = file.clone();
            changed[at] ^= mask;
            fs::write(&path, changed).unwrap();
            let compared = sim_server(&["compare", table]);
            assert!(!compared.stderr.contains("panicked"), "byte {at}, {mask:#x}: {compared:#?}");
            assert!(matches!(compared.code, Some(1 | 2)), "byte {at}, {mask:#x}: {compared:#?}");
            assert!(compared.stderr.contains(table), "byte {at}, {mask:#x}: {compared:#?}");
            refused += usize::from(compared.stderr.contains("damaged"));
        }
    }
    assert!(refused > 0, "no change made the reader panic: the test changes other bytes");
}
