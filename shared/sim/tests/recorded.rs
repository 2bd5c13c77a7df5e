//! A recorded run is the simulated one, with any source of commands.

use rusty_contract::log::LogError;
use rusty_contract::{Log, RunConfig, ScriptConfig};
use rusty_geometry::Twist;
use rusty_sim::patrol::Patrol;
use rusty_sim::{BuiltInScript, GOLDENS, Moment, Script, SimError, record};

mod common;

fn built_in(config: &RunConfig) -> BuiltInScript {
    BuiltInScript::new(&config.script, config.dt_s, config.start)
}

fn hex(digest: [u8; 16]) -> String {
    rusty_contract::digest::hex(&digest)
}

#[test]
fn every_golden_run_has_its_digest_as_a_log_and_comes_again_from_it() {
    for golden in GOLDENS {
        let log = golden.record().unwrap();
        assert_eq!(hex(log.trailer.world_digest), golden.expected, "{}", golden.name);
        assert_eq!(log.records.len() as u64, golden.config().ticks);
        let bytes = log.write(Vec::new()).unwrap();
        let read = Log::read(&bytes[..], "golden").unwrap();
        assert_eq!(read, log, "{}", golden.name);
        // The header alone gives the run again: a list of commands is in it.
        let mut script = built_in(&read.header.config);
        assert_eq!(record(read.header.config, &mut script).unwrap(), log, "{}", golden.name);
    }
}

#[test]
fn the_log_says_what_gave_the_commands() {
    let config = common::config(common::steered(), &rusty_geometry::open(), common::patrol_start());
    let mut steered = built_in(&config);
    let named = record(config.clone(), &mut steered).unwrap();
    assert_eq!(named.header.config, config);
    // The same commands without a name are a list.
    let mut unnamed = |moment: &Moment<'_>| Script::command(&mut steered, moment);
    let listed = record(config.clone(), &mut unnamed).unwrap();
    assert_eq!(listed.records, named.records);
    let ScriptConfig::Commands { list, .. } = &listed.header.config.script else {
        panic!("{:?}", listed.header.config.script.kind());
    };
    assert_eq!(list.len() as u64, config.ticks);
    // And a patrol on its timetable is a script, too.
    let ScriptConfig::TruthSteeredPatrol(timetable) = config.script else { panic!() };
    let mut patrol = Patrol::new(&timetable, config.dt_s);
    let log = record(config, &mut patrol).unwrap();
    assert_ne!(log.records, named.records);
}

#[test]
fn a_script_sees_tick_time_last_frame_and_truth() {
    let config = common::config(common::patrol(), &rusty_geometry::open(), common::patrol_start());
    let dt_s = config.dt_s;
    let mut seen = Vec::new();
    let log = record(config, &mut |moment: &Moment<'_>| {
        let frame = moment.frame.map(|frame| (frame.tick(), frame.encoders()));
        seen.push((moment.tick, moment.time_s, frame, moment.truth));
        Twist { v_m_s: 0.5, omega_rad_s: 0.1 }
    })
    .unwrap();
    assert_eq!((seen[0].0, seen[0].1, seen[0].2), (0, 0.0, None));
    assert_eq!(seen[0].3, common::patrol_start());
    for (before, now) in log.records.iter().zip(&seen[1..]) {
        let (tick, time_s, frame, truth) = *now;
        assert_eq!((tick, time_s), (before.tick + 1, tick as f64 * dt_s));
        assert_eq!(frame, Some((before.tick, before.ticks)));
        assert_eq!(Some(truth), before.pose_in_world());
    }
}

#[test]
fn a_command_that_cannot_be_used_is_refused_by_its_tick() {
    let config = common::config(common::patrol(), &rusty_geometry::open(), common::patrol_start());
    for (bad, word) in [(f64::NAN, "NaN"), (1e9, "1000000000")] {
        let mut script = |moment: &Moment<'_>| Twist {
            v_m_s: if moment.tick == 7 { bad } else { 0.1 },
            omega_rad_s: 0.0,
        };
        let error = record(config.clone(), &mut script).unwrap_err();
        let SimError::Config(error) = &error else { panic!("{error}") };
        assert_eq!((error.field.as_str(), error.value.as_str()), ("script.list[7].v_m_s", word));
    }
    let long = RunConfig { ticks: 1_000_001, ..config };
    let error = record(long, &mut |_: &Moment<'_>| panic!("was asked")).unwrap_err();
    assert!(matches!(&error, SimError::Config(e) if e.field == "ticks"), "{error}");
    let missing = Log::load(std::path::Path::new("/no/such/log")).unwrap_err();
    assert!(matches!(missing, LogError::Io { .. }), "{missing}");
}
