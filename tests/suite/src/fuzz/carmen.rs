//! A CARMEN log of a real robot, plain or gzip, and the run log made from it.

use std::path::{Path, PathBuf};

use rusty_contract::log::{Ending, LogReader, Read};
use rusty_logs::import::{ImportOptions, import_carmen};

/// Words of the format.
pub const WORDS: [&str; 14] = [
    "ODOM ",
    "FLASER 3 ",
    "RLASER ",
    "PARAM robot_frontlaser_offset 0.1\n",
    "\n",
    "# ",
    "nan",
    "PARAM robot_front_laser_max 1e999\n",
    "inf",
    "-inf",
    "1e999",
    "-1",
    " nohost ",
    "\u{1f}\u{8b}",
];

thread_local! {
    /// A folder for each thread, gone with it; in memory where there is such.
    static FOLDER: tempfile::TempDir = {
        let memory = Path::new("/dev/shm");
        let made = match memory.is_dir() {
            true => tempfile::Builder::new().prefix("rusty-fuzz-").tempdir_in(memory),
            false => tempfile::tempdir(),
        };
        made.expect("a folder for the recording")
    };
}

/// Imports the recording and reads the run log.
pub fn carmen(bytes: &[u8]) -> bool {
    let (input, output): (PathBuf, PathBuf) =
        FOLDER.with(|folder| (folder.path().join("in.log"), folder.path().join("out.log")));
    std::fs::write(&input, bytes).expect("a file can be written");
    let mut lines = 0;
    let options = ImportOptions { writer: "fuzz", strict: false };
    let Ok(report) = import_carmen(&input, &output, options, &mut |done| lines = done) else {
        return false;
    };
    assert_eq!(report.lines, lines, "progress ends with the last line");
    let mut reader = LogReader::open(&output).expect("what was imported is a log");
    reader.header().check().expect("its header can be used");
    let (mut ticks, mut scans) = (0, 0);
    loop {
        match reader.read().expect("the file is there") {
            Read::Tick(entry) => {
                let record = entry.record;
                assert!(entry.intact);
                assert!(record.time_s(reader.header().config.dt_s).is_finite());
                assert!(record.pose_in_world().is_none_or(|p| p.is_finite()));
                for range_m in record.ranges_m.iter().flatten() {
                    assert!(*range_m >= 0.0, "{range_m}");
                }
                scans += u64::from(record.ranges_m.is_some());
                ticks += 1;
            }
            Read::End(Ending::Complete(_)) => break,
            Read::End(cut) => panic!("{cut:?}"),
        }
    }
    assert_eq!((report.ticks, report.scans), (ticks, scans));
    assert!(!report.to_string().is_empty());
    true
}
