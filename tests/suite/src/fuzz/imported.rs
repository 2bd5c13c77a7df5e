//! A run log that an import made: it can be read to its end, and is what was reported.

use std::path::{Path, PathBuf};

use rusty_contract::log::{Ending, LogReader, Read};
use rusty_logs::import::ImportReport;

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

/// A file of this thread.
pub fn place(name: &str) -> PathBuf {
    FOLDER.with(|folder| folder.path().join(name))
}

/// Reads the run log `output` of an import whose progress ended with `lines`.
pub fn check(report: &ImportReport, output: &Path, lines: u64) {
    assert_eq!(report.lines, lines, "progress ends with the last line");
    let mut reader = LogReader::open(output).expect("what was imported is a log");
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
}
