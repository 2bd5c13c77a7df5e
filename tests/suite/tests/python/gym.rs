//! `rusty.gym`: the frames of a run to the bit, and what Gymnasium asks of environments.

use std::collections::BTreeMap;

use rusty_contract::ScriptConfig;
use rusty_contract::digest::hex;
use rusty_contract::log::Log;
use rusty_geometry::Material;
use rusty_tests::gymnasium::gymnasium;
use rusty_tests::python::{python, script};
use rusty_tests::*;

/// The document that a script among the tests prints; `None` where Gymnasium is not there.
#[track_caller]
fn said(file: &str, args: &[&str]) -> Option<Value> {
    let mut command = gymnasium()?;
    command.arg(script(file)).args(args);
    Some(Process::spawn(&mut command).wait().expect(0).json())
}

/// Repeats a run in an environment: every frame is the run's, and so is the world digest.
/// Returns the document of the environment and the log.
#[track_caller]
fn repeated(tag: &str, scenario: &str, args: &[&str]) -> Option<(Value, Log)> {
    let out = folder();
    launch(tag, out.path(), &[&[scenario], args].concat());
    let path = out.at("run.log");
    let log = Log::load(&path).unwrap();
    let said = said("gym_run.py", &[scenario, arg(&path)])?;
    assert_eq!(text(&said, "world_digest"), hex(&log.trailer.world_digest));
    assert_eq!(said["frames"], log.records.len());
    Some((said, log))
}

#[test]
fn an_environment_with_the_commands_of_a_run_has_its_frames_to_the_bit() {
    let Some((said, log)) = repeated("gym", "apartment", &["--ticks", "300"]) else { return };
    let with_scan = log.records.iter().filter(|record| record.ranges_m.is_some()).count();
    assert_eq!((&said["scans"], with_scan), (&json!(60), 60));
}

#[test]
fn the_readings_of_every_small_sensor_are_those_of_the_run() {
    let place = folder();
    let scenario = sensed_scenario(place.path(), "all.toml", "imu = {}");
    let Some((said, log)) = repeated("gym-sensed", &scenario, &[]) else { return };
    let walls = log.header.config.world.walls.iter();
    let numbers = walls.filter_map(|wall| match wall.material {
        Material::Door(number) => Some(number),
        _ => None,
    });
    let doors = 1 + numbers.max().unwrap();
    let blocked = said["blocked"].as_array().unwrap().iter().filter(|b| **b == json!(true));
    assert!(blocked.count() > 10, "the robot drives into a wall");
    // Of each sensor the newest reading, which its next one replaces.
    let mut newest = BTreeMap::new();
    for (tick, record) in log.records.iter().enumerate() {
        let readings = record.readings.get();
        let single = |x: f64| f64::from(x as f32);
        let bits = readings.bumper().unwrap();
        newest.insert("bumper", json!([0, 1, 2, 3, 4].map(|k| f64::from(bits >> k & 1))));
        let imu = readings.imu().unwrap();
        let imu = [imu.yaw_rate_rad_s, imu.accel_x_m_s2, imu.accel_y_m_s2].map(single);
        newest.insert("imu", json!(imu));
        if let Some(ranges_m) = readings.sonar_ranges_m() {
            newest.insert("sonars_m", json!([single(ranges_m[0])]));
        }
        if let Some(seen) = readings.doors() {
            let has = |number: u8| f64::from(u8::from(seen.contains(&number.into())));
            newest.insert("doors", (0..doors).map(has).collect());
        }
        if let Some(seen) = readings.landmarks() {
            let id = |id: Option<u32>| id.map_or(-1.0, f64::from);
            let seen = seen.iter().map(|s| [id(s.id()), single(s.range_m), single(s.bearing_rad)]);
            let no_landmark = std::iter::repeat([-1.0, 0.0, 0.0]);
            let rows: Vec<[f64; 3]> = seen.chain(no_landmark).take(4).collect();
            newest.insert("landmarks", json!(rows));
        }
        assert_eq!(newest.len(), 5, "every sensor has a reading in tick 0");
        for (name, expected) in &newest {
            assert_eq!(said["readings"][name][tick], *expected, "{name} in tick {tick}");
        }
    }
}

#[test]
fn the_run_digest_is_that_of_a_run_in_which_no_participant_answers() {
    let place = folder();
    // Too fast for the wheels, and numbers that no float32 is.
    let list = "{ v_m_s = 0.1, omega_rad_s = -0.3 }, { v_m_s = 3.0, omega_rad_s = 1.7 }";
    let lines = format!(
        "seed = 18446744073709551615\nticks = 40\nscan_every = 4\n\
         script = {{ kind = \"commands\", list = [{}] }}\n{RECORDERS}",
        vec![list; 20].join(", ")
    );
    let scenario = write(place.path(), "commands.toml", lines);
    let Some((said, log)) = repeated("gym-commands", &scenario, &[]) else { return };
    assert!(matches!(&log.header.config.script, ScriptConfig::Commands { list, .. }
        if list.len() == 40 && list[1].v_m_s == 3.0));
    assert_eq!(text(&said, "run_digest"), hex(&log.trailer.run_digest));
}

#[test]
fn the_checker_of_gymnasium_finds_no_fault() {
    let Some(said) = said("gym_check.py", &[]) else { return };
    let rounds = said.as_array().unwrap();
    assert_eq!(rounds.len(), 5);
    for round in rounds {
        // Commands have units, and small sensors no bounds.
        let known = ["symmetric and normalized", "infinity. This is probably too"];
        let other =
            round["warnings"].as_array().unwrap().iter().filter(|warning| {
                !known.iter().any(|known| warning.as_str().unwrap().contains(known))
            });
        assert_eq!(other.count(), 0, "{round}");
    }
}

#[test]
fn worlds_that_are_stepped_together_are_those_of_one_environment_each() {
    let Some(said) = said("gym_vector.py", &[]) else { return };
    assert_eq!(said["rounds"], 3, "threads and copies make no difference");
    assert!(number(&said, "episodes") >= 5.0, "{said}");
}

#[test]
fn rewards_ends_and_truth_are_as_documented() {
    let Some(said) = said("gym_tasks.py", &[]) else { return };
    let near = |name: &str, expected: f64, error: f64| {
        assert!((number(&said, name) - expected).abs() < error, "{name}: {said}");
    };
    // 0.7 m at 0.01 m a tick, and 1 at the goal.
    near("goal_ticks", 70.0, 3.0);
    near("goal_reward", 1.7, 0.02);
    // 0.89 m to the wall at 0.01 m a tick, and -1 there.
    near("distance_ticks", 90.0, 3.0);
    near("distance_reward", -0.11, 0.02);
    assert_eq!(said["truncated_at"], 20);
    assert_eq!(said["info"], json!(["digest", "tick", "time_s"]));
    assert_eq!(said["info_with_truth"], json!(["blocked", "digest", "tick", "time_s", "truth"]));
    assert_eq!(said["reset_seeds"], json!([7, true, true]), "then drawn ones, repeatably");
}

#[test]
fn what_cannot_be_used_is_refused_with_value_and_remedy() {
    let Some(said) = said("gym_errors.py", &[]) else { return };
    for (name, kind, words) in [
        ("scenario", "ValueError", &["apartmnt", "did you mean \"apartment\"?"][..]),
        ("field", "ValueError", &["lidar.beems", "did you mean \"beams\"?"]),
        ("count", "ValueError", &["num_envs", "1 to 65536", "got 0"]),
        ("threads", "ValueError", &["threads", "1 to 1024", "got 0"]),
        ("seed", "ValueError", &["18446744073709551616", "2**64 - 1"]),
        ("seeds", "ValueError", &["expected 3 seeds, got 2"]),
        ("not_reset", "RuntimeError", &["call reset()"]),
        ("nan", "ValueError", &["environment 1", "[0.5, nan]", "policy"]),
        ("shape", "ValueError", &["(3, 2)", "got (2, 2)"]),
        ("at_end", "ValueError", &["(3, 2)", "got (2, 2)"]),
        ("task", "ValueError", &["rewards of shape (3,)", "got ()"]),
        ("crowd", "ValueError", &["crowd.people", "found no room"]),
        ("fork", "RuntimeError", &["fork", "make them in this process"]),
        ("world_file", "ValueError", &["absent.toml"]),
    ] {
        let error = said[name].as_array().unwrap_or_else(|| panic!("{name}: {said}"));
        let message = error[1].as_str().unwrap();
        let has_all = words.iter().all(|words| message.contains(words));
        assert!(error[0] == kind && has_all, "{name}: {error:?}");
    }
    assert_eq!(said["ticks_after"], json!([1, 1, 1]), "a refused action moves no world");
    assert_eq!(said["same_seeds"], true, "and draws no seed");
}

#[test]
fn what_is_not_installed_is_named_with_the_command_that_installs_it() {
    let Some(python) = python() else { return };
    let code = "import rusty\ntry: import rusty.gym\nexcept ImportError as e: print(e)";
    let ended = Process::spawn(Command::new(python).args(["-c", code])).wait().expect(0);
    assert!(ended.stdout.contains("pip install 'gymnasium>=1.1'"), "{ended:?}");
    let Some(mut python) = gymnasium() else { return };
    let absent = format!("import sys; sys.modules['rusty._gym'] = None\n{code}");
    let ended = Process::spawn(python.args(["-c", &absent])).wait().expect(0);
    assert!(ended.stdout.contains("pip install ./sim-server/gym"), "{ended:?}");
}

#[test]
fn the_measurement_of_speed_prints_both_rates() {
    let Some(mut python) = gymnasium() else { return };
    let args = ["-m", "rusty.gym", "--num-envs", "8", "--seconds", "0.05", "--json"];
    let said = Process::spawn(python.args(args)).wait().expect(0).json();
    let rates = &said["steps_per_s"];
    assert!(number(rates, "without_scans") > 0.0 && number(rates, "with_scans") > 0.0, "{said}");
    let Some(mut python) = gymnasium() else { return };
    let ended = Process::spawn(python.args(["-m", "rusty.gym", "apartmnt"])).wait().expect(2);
    assert!(ended.stderr.contains("did you mean \"apartment\"?"), "{ended:?}");
}
