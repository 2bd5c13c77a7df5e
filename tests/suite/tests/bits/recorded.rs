//! Logs recorded without a server are logs like any other.

use rusty_contract::Log;
use rusty_geometry::Twist;
use rusty_sim::{BuiltInScript, Moment, record};
use rusty_tests::*;

/// Saves a log, has it verified, and returns its path.
#[track_caller]
fn verified(log: &Log, folder: &Folder) -> PathBuf {
    let path = folder.at("recorded.log");
    log.save(&path).unwrap();
    let verdict = about("verify", &path, &["--json"]).expect(0).json();
    assert_eq!(verdict["bit_exact"], true, "{verdict}");
    assert_eq!(verdict["re_simulated"], true, "{verdict}");
    assert_eq!(verdict["ticks"].as_u64(), Some(log.trailer.ticks));
    path
}

#[test]
fn a_recorded_run_has_the_bytes_of_a_loggers_but_for_writer_and_roster() {
    let args = ["--ticks", "200", "--without", "dead-reckoning", "--without", "score"];
    let (_out, live) = logged("recorded", &args);
    let theirs = Log::load(&live).unwrap();
    let config = config_of("apartment", &["ticks=200"]);
    let mut script = BuiltInScript::new(&config.script, config.dt_s, config.start);
    let mut ours = record(config, &mut script).unwrap();
    let folder = folder();
    let path = verified(&ours, &folder);
    assert_eq!(Log::load(&path).unwrap(), ours);
    ours.header.writer.clone_from(&theirs.header.writer);
    ours.header.roster.clone_from(&theirs.header.roster);
    assert!(ours.write(Vec::new()).unwrap() == fs::read(&live).unwrap(), "the bytes differ");
}

#[test]
fn a_run_with_a_script_of_ones_own_verifies_and_is_replayed() {
    let config = config_of("apartment", &["ticks=150", "sensors.bumper={}"]);
    // Turns away from what is near, as the last scan shows it.
    let mut is_near = false;
    let mut shy = |moment: &Moment<'_>| {
        if let Some(ranges_m) = moment.frame.and_then(|frame| frame.ranges_m()) {
            is_near = ranges_m.iter().any(|range_m| *range_m < 0.7);
        }
        Twist { v_m_s: 0.4, omega_rad_s: if is_near { 1.0 } else { 0.1 } }
    };
    let log = record(config, &mut shy).unwrap();
    let turned = log.records.iter().filter(|record| record.command.omega_rad_s == 1.0).count();
    assert!((1..150).contains(&turned), "{turned}");
    let folder = folder();
    let path = verified(&log, &folder);
    // An estimator that was not there gets the frames of the log.
    let args = ["--add", "dead-reckoning=dead-reckoning"];
    let report = replay(&path, &folder.at("again"), &args).expect(0).json();
    assert_eq!(report["ticks"], 150);
    assert_eq!(
        text(&report, "world_digest"),
        rusty_contract::digest::hex(&log.trailer.world_digest)
    );
}
