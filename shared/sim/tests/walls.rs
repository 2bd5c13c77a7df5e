//! Walls hold, whatever the commands; and what cannot begin says why.

mod common;

use common::{config, patrol_start, sim};
use proptest::prelude::*;
use rusty_contract::{Frame, RunConfig, ScriptConfig};
use rusty_geometry::{SE2, Twist, apartment, open};
use rusty_sim::{Sim, SimError, StepOutcome};

fn driven() -> RunConfig {
    let mut config = config(ScriptConfig::Driver {}, &apartment(), patrol_start());
    config.robot.slip_std = 0.1;
    config
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_command_moves_a_body_into_a_wall(
        seed in any::<u64>(),
        commands in prop::collection::vec((-3.0_f64..3.0, -30.0_f64..30.0), 60),
    ) {
        let mut config = driven();
        config.seed = seed;
        let mut sim = sim(config);
        let mut frame = Frame::boxed();
        for (v_m_s, omega_rad_s) in commands {
            let before = sim.truth();
            let outcome = sim.step(Some(Twist { v_m_s, omega_rad_s }), &mut frame);
            let after = sim.truth();
            prop_assert!(after.is_finite());
            prop_assert!(!sim.world().blocks(&after, &after, 0.11));
            if outcome == StepOutcome::Blocked {
                prop_assert_eq!(before, after);
            }
            let rates = sim.config().robot.nominal().drive.wheel_rates(frame.command());
            prop_assert!(rates.left_rad_s.abs() <= 20.0 && rates.right_rad_s.abs() <= 20.0);
        }
    }
}

#[test]
fn a_frame_tells_tick_time_and_the_command_as_applied() {
    let mut sim = sim(driven());
    let mut frame = Frame::boxed();
    let _ = sim.step(None, &mut frame);
    assert_eq!((frame.tick(), sim.tick()), (0, 1));
    assert_eq!(frame.command(), Twist::default(), "no driver yet: it stands");
    let too_fast = Twist { v_m_s: 6.6, omega_rad_s: 0.0 };
    let _ = sim.step(Some(too_fast), &mut frame);
    assert_eq!(frame.tick(), 1);
    assert!((frame.time_s() - 0.2).abs() < 1e-15);
    assert!((frame.command().v_m_s - 0.66).abs() < 1e-12);
}

#[test]
fn a_start_in_a_wall_is_refused_with_the_way_out() {
    let mut config = driven();
    config.start = SE2::new(11.95, 3.0, 0.0);
    let error = Sim::new(config.clone()).unwrap_err();
    assert!(matches!(error, SimError::StartInWall { .. }));
    let text = error.to_string();
    for part in ["start = (11.95, 3)", "apartment", "0.050000 m away", "0.060000 m"] {
        assert!(text.to_lowercase().contains(part), "{part:?} in {text}");
    }
    config.world = open().spec().clone();
    assert!(Sim::new(config).is_ok());
}

#[cfg(debug_assertions)]
#[test]
#[should_panic(expected = "not finite; refuse it where it is received")]
fn a_command_that_is_not_finite_is_the_callers_mistake() {
    let not_a_number = Twist { v_m_s: f64::NAN, omega_rad_s: 0.0 };
    let _ = sim(driven()).step(Some(not_a_number), &mut Frame::boxed());
}
