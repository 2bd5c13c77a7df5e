//! The robot is carried away: what that changes, and what it does not.

#![allow(clippy::unwrap_used, missing_docs)]

mod common;

use rusty_contract::config::Event;
use rusty_contract::{Frame, Kidnapping, RunConfig, ScriptConfig};
use rusty_geometry::{SE2, apartment};
use rusty_sim::Sim;

fn base() -> RunConfig {
    let script = ScriptConfig::Straight { v_m_s: 0.2 };
    let mut config = common::config(script, &apartment(), SE2::new(6.0, 4.5, 0.0));
    (config.ticks, config.scan_every) = (30, 5);
    config
}

fn kidnapped(list: &[(u64, SE2)]) -> RunConfig {
    let kidnappings = list.iter().map(|&(tick, to)| Kidnapping { tick, to }).collect();
    RunConfig { kidnappings, ..base() }
}

/// Truths and frames of a run.
fn drive(sim: &mut Sim) -> Vec<(SE2, Box<Frame>)> {
    let ticks = sim.config().ticks - sim.tick();
    let step = |_| {
        let mut frame = Frame::boxed();
        let _ = sim.step(None, &mut frame);
        frame.write_digest(true);
        (sim.truth(), frame)
    };
    (0..ticks).map(step).collect()
}

fn run(config: RunConfig) -> Vec<(SE2, Box<Frame>)> {
    drive(&mut Sim::new(config).unwrap())
}

#[test]
fn it_goes_on_from_where_it_is_put_and_its_wheels_know_nothing() {
    let to = SE2::new(2.0, 1.5, 1.0);
    let (free, taken) = (run(base()), run(kidnapped(&[(10, to)])));
    for tick in 0..30 {
        let (a, b) = (&free[tick], &taken[tick]);
        assert_eq!(a.1.encoders(), b.1.encoders(), "the wheels turn as they did");
        assert_eq!(a.0 == b.0, tick < 10);
        if tick >= 10 {
            // The same motion, from another place.
            let before = free[9].0;
            let (moved, moved_there) = (a.0.boxminus(&before), b.0.boxminus(&to));
            assert!((moved - moved_there).norm() < 1e-9, "tick {tick}");
        }
    }
    let same = |tick: usize| free[tick].1.ranges_m().unwrap() == taken[tick].1.ranges_m().unwrap();
    assert!(same(5) && !same(10), "scans are those of the place");
}

#[test]
fn a_restart_and_a_clone_have_it_again_and_a_change_may_bring_it() {
    let to = SE2::new(2.0, 1.5, 1.0);
    let config = kidnapped(&[(3, SE2::new(6.0, 3.5, 0.0)), (20, to)]);
    let all = |run: &[(SE2, Box<Frame>)]| -> Vec<_> {
        run.iter().map(|(truth, frame)| (*truth, frame.digest())).collect()
    };
    let mut sim = Sim::new(config.clone()).unwrap();
    let first = all(&drive(&mut sim));
    sim.restart(config.seed);
    assert_eq!(all(&drive(&mut sim)), first);
    // Brought in the middle: what is past stays past.
    let mut sim = Sim::new(kidnapped(&[(3, SE2::new(6.0, 3.5, 0.0))])).unwrap();
    let mut frame = Frame::boxed();
    for _ in 0..15 {
        let _ = sim.step(None, &mut frame);
    }
    sim.reconfigure(config).unwrap();
    assert_eq!(all(&drive(&mut sim)), first[15..]);
}

#[test]
fn a_place_in_a_wall_is_refused_at_the_start_and_in_the_middle() {
    let bad = kidnapped(&[(10, SE2::new(11.95, 3.0, 0.0))]);
    let error = Sim::new(bad.clone()).unwrap_err().to_string();
    assert!(error.starts_with("kidnapping[0].to = (11.95, 3) m"), "{error}");
    let mut sim = Sim::new(base()).unwrap();
    assert!(sim.reconfigure(bad).is_err());
    assert_eq!(sim.config(), &base(), "nothing has changed");
    let error = Sim::new(kidnapped(&[(10, SE2::new(200.0, 3.0, 0.0))])).unwrap_err().to_string();
    assert!(error.starts_with("kidnapping[0].to = (200, 3) m: lies outside"), "{error}");
    for start in [SE2::new(200.0, 3.0, 0.0), SE2::new(6.0, -7.0, 0.0)] {
        let error = Sim::new(RunConfig { start, ..base() }).unwrap_err().to_string();
        assert!(error.starts_with("start = (") && error.contains("lies outside"), "{error}");
    }
    let twice = kidnapped(&[(10, SE2::new(6.0, 3.5, 0.0)), (10, SE2::new(6.0, 3.0, 0.0))]);
    let error = Sim::new(twice).unwrap_err().to_string();
    assert!(error.starts_with("kidnapping[1].tick = 10: is not after"), "{error}");
}

#[test]
fn a_place_is_checked_among_the_walls_of_its_tick() {
    let (door, middle) = (SE2::new(0.05, 4.5, 0.0), SE2::new(6.0, 3.5, 0.0));
    let open = Event::OpenDoor { tick: 4, door: 0 };
    let put = Event::PutBox { tick: 6, number: 1, at: middle, size_m: [0.4, 0.1] };
    let with =
        |tick, to| Sim::new(RunConfig { events: vec![open, put], ..kidnapped(&[(tick, to)]) });
    assert!(with(4, door).is_ok() && with(5, middle).is_ok());
    assert!(with(3, door).is_err() && with(6, middle).is_err());
}
