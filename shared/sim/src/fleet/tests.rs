//! Robots that meet.

use rusty_contract::config::{CrowdConfig, Fleet as FleetConfig, OtherRobot};
use rusty_contract::{Frame, RobotConfig, RunConfig, Scenario, ScriptConfig};
use rusty_geometry::{SE2, Twist, apartment, open};

use crate::Sim;

/// One robot of a test: its name, start and script.
type One = (&'static str, SE2, ScriptConfig);

fn straight(v_m_s: f64) -> ScriptConfig {
    ScriptConfig::Straight { v_m_s }
}

/// The run of the robot at `place`.
fn config(base: &RunConfig, robots: &[One], place: usize) -> RunConfig {
    let other = |(name, start, script): &One| OtherRobot {
        name: (*name).to_owned(),
        start: *start,
        robot: RobotConfig::default(),
        script: script.clone(),
        kidnappings: Vec::new(),
    };
    let others = robots.iter().enumerate().filter(|(i, _)| *i != place);
    let others = others.map(|(_, robot)| other(robot)).collect();
    let (name, start, script) = robots[place].clone();
    let fleet = Some(Box::new(FleetConfig { name: name.to_owned(), place, others }));
    RunConfig { start, script, fleet, ..base.clone() }
}

fn base() -> RunConfig {
    Scenario { ticks: 2000, ..Scenario::default() }.config(apartment().spec().clone())
}

fn eight() -> ScriptConfig {
    ScriptConfig::FigureEight { v_m_s: 0.4, omega_rad_s: 0.8, half_s: 7.5 }
}

#[test]
fn every_robots_simulation_has_the_same_robots_and_people() {
    let crowd = Some(CrowdConfig { people: 4, avoids_robot: true, ..CrowdConfig::default() });
    let base = RunConfig { crowd, ..base() };
    let robots = [
        ("a", SE2::new(6.0, 4.5, 0.0), base.script.clone()),
        ("b", SE2::new(9.0, 4.4, 3.0), straight(0.3)),
        ("c", SE2::new(9.0, 2.0, 1.0), eight()),
    ];
    let mut sims = [0, 1, 2].map(|place| Sim::new(config(&base, &robots, place)).unwrap());
    let mut frame = Frame::boxed();
    let mut blocked = 0;
    for tick in 0..1500 {
        for sim in &mut sims {
            blocked += u32::from(sim.step(None, &mut frame) == crate::StepOutcome::Blocked);
        }
        let seen = |sim: &Sim, robot: usize| {
            // People first, then the other robots in the order of their places.
            let people = sim.bodies().len() - 2;
            sim.bodies()[people + robot].centre
        };
        let [a, b, c] = &sims;
        let at = |sim: &Sim| nalgebra::Point2::from(sim.truth().translation());
        assert_eq!((seen(b, 0), seen(c, 0)), (at(a), at(a)), "tick {tick}");
        assert_eq!((seen(a, 0), seen(c, 1)), (at(b), at(b)), "tick {tick}");
        assert_eq!((seen(a, 1), seen(b, 1)), (at(c), at(c)), "tick {tick}");
        let people = a.bodies().len() - 2;
        assert_eq!(a.bodies()[..people], b.bodies()[..people], "tick {tick}");
        let bodies = [(at(a), at(b)), (at(a), at(c)), (at(b), at(c))];
        assert!(bodies.iter().all(|(p, q)| (p - q).norm() >= 0.22 - 1e-12), "tick {tick}");
    }
    assert!(blocked > 0, "they never met: the test shows too little");
}

#[test]
fn a_robot_more_changes_no_noise_of_another() {
    let base = base();
    // In another room, where the first robot's LiDAR never looks.
    let hidden = ("z", SE2::new(1.0, 8.0, 0.0), straight(0.0));
    let a = ("a", base.start, base.script.clone());
    let b = ("b", SE2::new(9.0, 2.0, 1.0), eight());
    let mut alone = Sim::new(base.clone()).unwrap();
    let mut with = Sim::new(config(&base, &[a.clone(), hidden.clone()], 0)).unwrap();
    let mut second = Sim::new(config(&base, &[a.clone(), b.clone()], 1)).unwrap();
    let mut third = Sim::new(config(&base, &[a, hidden, b], 2)).unwrap();
    let (mut one, mut other) = (Frame::boxed(), Frame::boxed());
    for _ in 0..400 {
        let _ = (alone.step(None, &mut one), with.step(None, &mut other));
        assert_eq!(one.observable(), other.observable());
        let _ = (second.step(None, &mut one), third.step(None, &mut other));
        assert_eq!(second.truth(), third.truth());
    }
}

#[test]
fn robots_draw_different_slip() {
    let base = base();
    let robots = [
        ("a", SE2::new(2.0, 2.0, 0.0), straight(0.3)),
        ("b", SE2::new(2.0, 3.0, 0.0), straight(0.3)),
    ];
    let base = RunConfig { world: open().spec().clone(), ..base };
    let mut sims = [0, 1].map(|place| Sim::new(config(&base, &robots, place)).unwrap());
    let mut frame = Frame::boxed();
    for sim in &mut sims {
        let _ = sim.step(None, &mut frame);
    }
    assert_ne!(sims[0].truth().x().to_bits(), sims[1].truth().x().to_bits());
}

#[test]
fn robots_block_and_see_each_other() {
    let mut base = RunConfig { world: open().spec().clone(), scan_every: 1, ..base() };
    (base.robot.slip_std, base.lidar.range_std_m, base.lidar.dropout) = (0.0, 0.0, 0.0);
    let robots = [
        ("a", SE2::new(0.0, 0.0, 0.0), straight(0.5)),
        ("b", SE2::new(2.0, 0.0, 0.0), straight(0.0)),
    ];
    let mut sim = Sim::new(config(&base, &robots, 0)).unwrap();
    let mut frame = Frame::boxed();
    let _ = sim.step(None, &mut frame);
    let ahead_m = frame.ranges_m().unwrap()[90];
    // 2 m, less one step of 1 cm and the body of 11 cm.
    assert!((ahead_m - 1.88).abs() < 1e-9, "{ahead_m}");
    for _ in 0..300 {
        let _ = sim.step(None, &mut frame);
    }
    let gap_m = 2.0 - sim.truth().x() - 0.22;
    assert!((-1e-12..0.01).contains(&gap_m), "{gap_m}");
}

#[test]
fn a_driven_robot_needs_its_commands() {
    let base = base();
    let robots = [
        ("a", SE2::new(6.0, 4.5, 0.0), straight(0.1)),
        ("b", SE2::new(9.0, 4.4, 3.0), ScriptConfig::Driver {}),
    ];
    let error = Sim::new(config(&base, &robots, 0)).unwrap_err().to_string();
    assert!(error.starts_with("robot[1].script.kind = driver: "), "{error}");
    let mut a = Sim::among_driven(config(&base, &robots, 0)).unwrap();
    let mut b = Sim::new(config(&base, &robots, 1)).unwrap();
    let mut frame = Frame::boxed();
    for tick in 0..200 {
        // Faster than its wheels.
        let command = Twist { v_m_s: 0.9, omega_rad_s: 0.01 * f64::from(tick) };
        a.drive_other(1, b.limit(command));
        let _ = (a.step(None, &mut frame), b.step(Some(command), &mut frame));
        assert_eq!(a.bodies()[0].centre.coords, b.truth().translation());
    }
    assert_ne!(b.truth(), robots[1].1);
}

#[test]
fn a_restart_and_a_clone_go_the_same_way() {
    let base = base();
    let robots = [
        ("a", SE2::new(6.0, 4.5, 0.0), base.script.clone()),
        ("b", SE2::new(9.0, 2.0, 1.0), eight()),
    ];
    let mut sim = Sim::new(config(&base, &robots, 0)).unwrap();
    let mut frame = Frame::boxed();
    for _ in 0..50 {
        let _ = sim.step(None, &mut frame);
    }
    sim.restart(7);
    let mut new = Sim::new(RunConfig { seed: 7, ..config(&base, &robots, 0) }).unwrap();
    for _ in 0..50 {
        let _ = (sim.step(None, &mut frame), new.step(None, &mut frame));
        assert_eq!((sim.truth(), sim.bodies()), (new.truth(), new.bodies()));
    }
}

#[test]
fn a_start_in_a_wall_names_the_robot() {
    let robots = [
        ("a", SE2::new(6.0, 4.5, 0.0), straight(0.1)),
        ("b", SE2::new(0.0, 4.5, 0.0), straight(0.1)),
    ];
    let error = Sim::new(config(&base(), &robots, 0)).unwrap_err().to_string();
    assert!(error.contains("robot[1].start"), "{error}");
}
