//! Tables of sweeps, as `compare` and `sweep --resume` read them.
//!
//! The inputs were written by `sim-server sweep hallway --seeds 0..4 --ticks 20`,
//! one with `--set robot.slip_std=0,0.02 --out FILE.parquet`, one with
//! `--out FILE.csv`.

use std::fs::File;
use std::io::Write as _;

use rusty_study::sweep::Table;

/// Reads the bytes as a Parquet file and as a CSV file. Accepted if all rows of
/// either can be read.
pub fn table(bytes: &[u8]) -> bool {
    let folder = tempfile::tempdir().expect("a folder");
    let read = |name: &str| {
        let path = folder.path().join(name);
        File::create(&path).and_then(|mut file| file.write_all(bytes)).expect("a file");
        let table = Table::at(&path).expect("a known ending");
        let _ = table.settings();
        let Ok(rows) = table.rows() else { return false };
        let columns = rows.names.len();
        rows.map(|row| row.map(|row| assert_eq!(row.len(), columns))).all(|row| row.is_ok())
    };
    // Both are tried, whatever the first one gives.
    read("table.parquet") | read("table.csv")
}
