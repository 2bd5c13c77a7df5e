//! What is wrong is named: file, line, field, value, remedy.

use flate2::Compression;
use flate2::write::GzEncoder;
use std::io::Write as _;

use super::{flaser, import_bytes, import_file, import_text, odom};
use crate::import::{ImportOptions, import_carmen};

const HERE: [f64; 3] = [0.0, 0.0, 0.0];

fn message(text: &str) -> String {
    match import_text(text) {
        Ok(imported) => panic!("imported: {}", imported.report),
        Err(error) => error.to_string(),
    }
}

fn assert_message(text: &str, parts: &[&str]) {
    let message = message(text);
    assert!(message.contains("some robot.log: "), "{message}");
    for part in parts {
        assert!(message.contains(part), "{part:?} is not in {message:?}");
    }
}

/// Each line, the third of a log, gives a message with all its parts.
fn assert_refused(cases: &[(&str, &[&str])]) {
    for (line, parts) in cases {
        let good = odom(HERE, 1.0);
        let text = format!("{good}# remark\n{line}\n{good}");
        assert_message(&text, &["line 3: "]);
        assert_message(&text, parts);
    }
}

#[test]
fn malformed_readings_are_named() {
    assert_refused(&[
        ("ODOM 0 abc 0 0 0 0 1 h 1", &["ODOM field 2 (y) = \"abc\": is no number; correct"]),
        ("ODOM nan 0 0 0 0 0 1 h 1", &["field 1 (x) = \"NaN\": is not finite"]),
        ("ODOM 0 0 inf 0 0 0 1 h 1", &["field 3 (theta) = \"inf\": is not finite"]),
        ("ODOM 0 2e6 0 0 0 0 1 h 1", &["field 2 (y) = \"2000000\": lies more than 900 km"]),
        ("ODOM 0 0 0 0 fast 0 1 h 1", &["field 5 (rv) = \"fast\""]),
        ("ODOM 0 0 0 0 0 0 now h 1", &["field 7 (stamp) = \"now\""]),
        ("ODOM 0 0 0 0 0 0 nan h 1", &["field 7 (stamp) = \"NaN\": is no time"]),
        ("ODOM 0 0 0 0 0 0 1 h x", &["field 9 (logger's stamp) = \"x\""]),
        ("ODOM 0 0 0", &["ODOM has 3 fields after its name, 9 are needed"]),
        ("ODOM 0 0 0 0 0 0 1 h 1 1", &["has 10 fields"]),
    ]);
}

#[test]
fn malformed_scans_are_named() {
    let scan = |middle: &str| format!("FLASER 3 {middle} 1.5 host 1.5");
    assert_refused(&[
        ("FLASER", &["FLASER field 1 (number of beams) = \"\": is no whole number"]),
        ("FLASER 0 0 0 0 0 0 0 1 h 1", &["= \"0\": a scan has at least one beam"]),
        ("FLASER -3 1", &["= \"-3\": is no whole number"]),
        ("FLASER 1081 1 2", &["= \"1081\": a scan has at most 1080 beams"]),
        ("FLASER 3 1 2 3 0 0 0", &["has 7 fields", "13 are needed", "cut off"]),
        (&scan("1 -2 3 0 0 0 0 0 0"), &["field 3 (range of beam 1) = \"-2\": is no distance"]),
        (&scan("1 2 nan 0 0 0 0 0 0"), &["field 4 (range of beam 2) = \"NaN\""]),
        (&scan("1 2 3m 0 0 0 0 0 0"), &["range of beam 2) = \"3m\": is no number"]),
        (&scan("1 2 3 0 0 0 0 0 ?"), &["field 10 (odom_theta) = \"?\""]),
        ("FLASER 1 2 0 0 0 0 0 0 inf h 1", &["field 9 (stamp) = \"inf\": is no time"]),
    ]);
}

#[test]
fn long_texts_are_cut_in_messages() {
    let word = "é".repeat(5000);
    let message = message(&format!("ODOM 0 0 {word} 0 0 0 1 h 1\n"));
    assert!(message.contains("… (5000 characters)") && message.len() < 400, "{message}");
    let line = format!("{}# {}\n", odom(HERE, 1.0), "x".repeat(1 << 20));
    assert_message(&line, &["line 2 is longer than 1048576 bytes", "newline"]);
    let fits = format!("{}# {}\n", odom(HERE, 1.0), "x".repeat((1 << 20) - 3));
    assert_eq!(import_text(&fits).unwrap().report.lines, 2);
}

#[test]
fn scans_of_another_size_are_refused() {
    let text = odom(HERE, 1.0)
        + &flaser(180, HERE, HERE, 1.1)
        + &odom(HERE, 1.2)
        + &flaser(181, HERE, HERE, 1.3);
    let expected = ["line 4: the scan has 181 beams", "(line 2) has 180", "split"];
    assert_message(&text, &expected);
}

#[test]
fn a_log_without_odometry_is_refused() {
    assert_message("", &["no odometry in 0 lines", "import a CARMEN log"]);
    assert_message("ROBOTLASER1 0 1 2\nSYNC x\n", &["what stands there is ROBOTLASER1, SYNC"]);
    let scans = flaser(180, HERE, HERE, 1.0) + &flaser(180, HERE, HERE, 2.0);
    assert_message(&scans, &["2 scans alone do not tell"]);
    // A file of another kind has a type of message per line.
    let text: String = (0..500).map(|i| format!("word{i} is here\n")).collect();
    assert_message(&text, &["no odometry in 500 lines"]);
    let report = import_text(&(text + &odom(HERE, 1.0))).unwrap().report;
    assert_eq!((report.skipped.len(), report.skipped["(others)"]), (65, 436));
}

#[test]
fn a_cut_gzip_says_how_far_it_got() {
    let text: String =
        (0..5000).map(|i| odom([f64::from(i * i % 977), 0.1, 0.2], f64::from(i))).collect();
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(text.as_bytes()).unwrap();
    let packed = encoder.finish().unwrap();
    for cut in [packed.len() / 2, packed.len() - 1] {
        let error = import_bytes("a.log.gz", &packed[..cut]).err().unwrap().to_string();
        assert!(error.contains("gzip stream is cut off after line "), "{error}");
        assert!(!error.contains("line 0 "), "{error}");
    }
    // The last eight bytes are checksum and length.
    let mut broken = packed.clone();
    broken[packed.len() - 8] ^= 1;
    let error = import_bytes("a.log.gz", &broken).err().unwrap();
    let error = error.to_string();
    assert!(error.contains("a.log.gz: after line 5000 "), "{error}");
    // A file that only begins like one.
    assert!(import_bytes("a.log.gz", &[0x1f, 0x8b]).is_err());
}

#[test]
fn files_that_cannot_be_used_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let good = folder.path().join("good.log");
    let output = folder.path().join("good.runlog");
    std::fs::write(&good, odom(HERE, 1.0)).unwrap();
    let import = |input: &std::path::Path, output: &std::path::Path| {
        let options = ImportOptions { writer: "test", strict: false };
        import_carmen(input, output, options, &mut |_| ()).unwrap_err().to_string()
    };
    let error = import(&folder.path().join("absent.log"), &output);
    assert!(error.contains("absent.log: ") && error.contains("give the path"), "{error}");
    let error = import(folder.path(), &output);
    assert!(error.contains("no regular file"), "{error}");
    let error = import(&good, &folder.path().join("absent/x.runlog"));
    assert!(error.contains("x.runlog: creating the run log: "), "{error}");
    let error = import(&good, &good);
    assert!(error.contains("same file"), "{error}");
    let error = import(&good, folder.path());
    assert!(error.contains("creating the run log: "), "{error}");
    let error = import(&good, std::path::Path::new("/"));
    assert!(error.contains("the path names no file"), "{error}");
    assert_eq!(std::fs::read_to_string(&good).unwrap(), odom(HERE, 1.0));
}

#[test]
fn a_failed_import_leaves_the_log_that_was_there() {
    let folder = tempfile::tempdir().unwrap();
    let (input, output) = (folder.path().join("a.log"), folder.path().join("a.runlog"));
    std::fs::write(&input, odom(HERE, 1.0)).unwrap();
    import_file(&input, &output).unwrap();
    let before = std::fs::read(&output).unwrap();
    std::fs::write(&input, odom(HERE, 1.0) + "ODOM 1\n").unwrap();
    assert!(import_file(&input, &output).is_err());
    assert_eq!(std::fs::read(&output).unwrap(), before);
    std::fs::write(&input, odom(HERE, 1.0) + &odom(HERE, 2.0)).unwrap();
    import_file(&input, &output).unwrap();
    assert_ne!(std::fs::read(&output).unwrap(), before);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
}
