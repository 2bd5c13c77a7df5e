//! A configuration that changes between two ticks changes only what it says.

mod common;

use common::{config, patrol, patrol_start, sim, steered};
use rusty_contract::config::PatrolConfig;
use rusty_contract::{Frame, RunConfig, ScriptConfig};
use rusty_geometry::apartment;
use rusty_sim::Sim;

const TICKS: usize = 80;
const AT: usize = 37;

/// Truth, encoder counts, command and scan of a tick, as bits.
type Shown = ([u64; 3], [i64; 2], [u64; 2], Option<Vec<u64>>);

fn base() -> RunConfig {
    let mut config = config(steered(), &apartment(), patrol_start());
    config.seed = 42;
    config.robot.slip_std = 0.02;
    config.scan_every = 2;
    config
}

fn go_on(sim: &mut Sim, ticks: usize) -> Vec<Shown> {
    let mut frame = Frame::boxed();
    let mut tick = || {
        let _ = sim.step(None, &mut frame);
        let (p, c) = (sim.truth(), frame.command());
        let scan = frame.ranges_m().map(|r| r.iter().map(|r| r.to_bits()).collect());
        let counts = [frame.encoders().left, frame.encoders().right];
        let pose = [p.x(), p.y(), p.theta()].map(f64::to_bits);
        (pose, counts, [c.v_m_s, c.omega_rad_s].map(f64::to_bits), scan)
    };
    (0..ticks).map(|_| tick()).collect()
}

/// A run that is changed before tick `AT`.
fn forked(change: impl FnOnce(&mut RunConfig)) -> Vec<Shown> {
    let mut sim = sim(base());
    let mut shown = go_on(&mut sim, AT);
    let mut config = base();
    change(&mut config);
    assert_eq!(sim.reconfigure(config), Ok(()));
    assert_eq!(sim.tick(), AT as u64);
    shown.extend(go_on(&mut sim, TICKS - AT));
    shown
}

#[test]
fn the_same_configuration_again_changes_nothing() {
    assert_eq!(forked(|_| {}), go_on(&mut sim(base()), TICKS));
}

#[test]
fn figures_of_the_lidar_that_change_in_the_middle_are_those_of_a_run_that_has_them() {
    let changes: [fn(&mut RunConfig); 3] = [
        |c| c.lidar.range_std_per_m = 0.01,
        |c| c.lidar.glass_visible_rad = 0.0,
        |c| c.lidar.divergence_rad = 0.02,
    ];
    let plain = go_on(&mut sim(base()), TICKS);
    for (i, change) in changes.into_iter().enumerate() {
        let mut config = base();
        change(&mut config);
        let whole = go_on(&mut sim(config), TICKS);
        let later = forked(change);
        assert_eq!(later[..AT], plain[..AT], "change {i}");
        assert_eq!(later[AT..], whole[AT..], "change {i}");
        assert_ne!(whole[AT..], plain[AT..], "change {i}");
    }
}

#[test]
fn noise_that_is_not_concerned_stays() {
    let plain = go_on(&mut sim(base()), TICKS);
    // Another LiDAR: the same way, and every beam that survives.
    let mut dropped = 0;
    for (tick, (a, b)) in plain.iter().zip(forked(|c| c.lidar.dropout = 0.5)).enumerate() {
        assert_eq!((a.0, a.1, a.2), (b.0, b.1, b.2), "tick {tick}");
        for (a, b) in a.3.iter().flatten().zip(b.3.iter().flatten()) {
            assert!(a == b || (tick >= AT && *b == 8.0f64.to_bits()), "tick {tick}");
            dropped += u32::from(a != b);
        }
    }
    assert!(dropped > 500, "{dropped}");
    // Another slip: the draws of a later tick are those of that tick.
    let slips = forked(|c| c.robot.slip_std = 0.04);
    assert_eq!(slips[..AT], plain[..AT]);
    assert_ne!(slips[AT].0, plain[AT].0);
    // From the start on or from the middle, the same wheels turn alike.
    let open = |c: &mut RunConfig| c.script = ScriptConfig::Patrol(PatrolConfig::default());
    let mut whole = base();
    open(&mut whole);
    let whole = go_on(&mut sim(whole), TICKS);
    let later = forked(open);
    assert!(later[AT..].iter().zip(&whole[AT..]).all(|(a, b)| a.2 == b.2));
}

#[test]
fn ranges_from_the_same_pose_have_the_same_noise_whatever_slips() {
    // A robot that stands slips not at all: same poses, so same ranges.
    let stand = |slip_std: f64| {
        let mut config = base();
        config.script = ScriptConfig::Straight { v_m_s: 0.0 };
        let mut sim = sim(config.clone());
        let mut shown = go_on(&mut sim, AT);
        config.robot.slip_std = slip_std;
        assert_eq!(sim.reconfigure(config), Ok(()));
        shown.extend(go_on(&mut sim, TICKS - AT));
        shown
    };
    assert_eq!(stand(0.02), stand(0.3));
}

#[test]
fn another_seed_holds_from_its_tick_on() {
    let (plain, forked) = (go_on(&mut sim(base()), TICKS), forked(|c| c.seed = 43));
    assert_eq!(forked[..AT], plain[..AT]);
    assert_ne!(forked[AT].0, plain[AT].0);
}

#[test]
fn what_must_stay_is_named_and_nothing_changes() {
    let mut sim = sim(base());
    let _ = go_on(&mut sim, AT);
    let rest = go_on(&mut sim.clone(), TICKS - AT);
    type Change = fn(&mut RunConfig);
    let refused: [(Change, &str); 3] = [
        (|c| c.dt_s = 0.2, "dt_s = 0.2: was 0.1 when the run began"),
        (|c| c.lidar.beams = 90, "lidar.beams = 90: was 180"),
        (|c| c.robot.slip_std = -1.0, "robot.slip_std = -1: is out of range"),
    ];
    for (change, words) in refused {
        let mut config = base();
        config.lidar.dropout = 0.9;
        change(&mut config);
        let error = sim.reconfigure(config).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
    assert_eq!(go_on(&mut sim, TICKS - AT), rest);
}

#[test]
fn a_restarted_world_is_a_new_one_of_that_seed() {
    for script in [steered(), patrol()] {
        let config = RunConfig { script, ..base() };
        let mut reused = sim(config.clone());
        for (seed, ticks) in [(3, 41), (9, 300), (3, 17)] {
            reused.restart(seed);
            let mut fresh = sim(RunConfig { seed, ..config.clone() });
            assert!(go_on(&mut reused, ticks) == go_on(&mut fresh, ticks), "seed {seed}");
            assert_eq!(reused.config(), fresh.config());
        }
    }
}
