//! Who walks where, and what the robot and its LiDAR meet.

use super::*;
use crate::Sim;
use rusty_contract::{Frame, Scenario, ScriptConfig};
use rusty_geometry::{apartment, open};

fn config(world: &World) -> RunConfig {
    let scenario = Scenario { ticks: 400, ..Scenario::default() };
    scenario.config(world.spec().clone())
}

fn crowd(people: u32) -> RunConfig {
    let crowd = CrowdConfig { people, ..CrowdConfig::default() };
    RunConfig { crowd: Some(crowd), ..config(&apartment()) }
}

fn walker(waypoints: &[[f64; 2]], shape: Shape) -> WalkerConfig {
    WalkerConfig { waypoints: waypoints.to_vec(), speed_m_s: 1.0, radius_m: 0.25, shape }
}

const NOWHERE: Disc = Disc { centre: Point2::new(-99.0, -99.0), radius_m: 0.11 };

#[test]
fn a_walker_goes_round_its_waypoints_at_its_speed() {
    let square = [[1.0, 1.0], [3.0, 1.0], [3.0, 3.0], [1.0, 3.0]];
    let run = RunConfig { walkers: vec![walker(&square, Shape::Disc)], ..config(&open()) };
    let mut people = People::new(&run, &open()).unwrap();
    assert_eq!(people.bodies(), [Disc { centre: Point2::new(1.0, 1.0), radius_m: 0.25 }]);
    let mut at = Vec::new();
    for tick in 0..400 {
        people.step(&open(), &[NOWHERE], tick);
        at.push(people.bodies()[0].centre);
    }
    for (tick, expected) in
        [(49, [2.0, 1.0]), (99, [3.0, 1.0]), (199, [3.0, 3.0]), (399, [1.0, 1.0])]
    {
        let error = length(&(at[tick] - Point2::from(expected)));
        assert!(error < 1e-9, "tick {tick}: {}", at[tick]);
    }
}

#[test]
fn a_walker_keeps_its_speed_past_waypoints_that_are_close_together() {
    // 1 m/s and 0.02 s: three waypoints of the first way in every step.
    let dense: Vec<[f64; 2]> = (0..=600).map(|k| [0.005 * f64::from(k), 0.0]).collect();
    let corner = [[0.0, 0.0], [0.03, 0.0], [0.03, 9.0]];
    for (way, ticks, expected) in
        [(&dense[..], 100, [2.0, 0.0]), (&corner, 2, [0.03, 0.01]), (&corner, 50, [0.03, 0.97])]
    {
        let run = RunConfig { walkers: vec![walker(way, Shape::Disc)], ..config(&open()) };
        let mut people = People::new(&run, &open()).unwrap();
        (0..ticks).for_each(|tick| people.step(&open(), &[NOWHERE], tick));
        let at = people.bodies()[0].centre;
        assert!((at - Point2::from(expected)).norm() < 1e-9, "{at}");
    }
    // Waypoints in one place are a place to stand.
    let run = RunConfig { walkers: vec![walker(&[[1.0, 2.0]; 3], Shape::Disc)], ..config(&open()) };
    let mut people = People::new(&run, &open()).unwrap();
    (0..9).for_each(|tick| people.step(&open(), &[NOWHERE], tick));
    assert_eq!(people.bodies()[0].centre, Point2::new(1.0, 2.0));
}

#[test]
fn a_walker_whom_the_robot_stops_on_the_last_step_still_goes_to_that_waypoint() {
    let way = [[1.0, 1.0], [3.0, 1.0], [3.0, 3.0]];
    let run = RunConfig { walkers: vec![walker(&way, Shape::Disc)], ..config(&open()) };
    let mut people = People::new(&run, &open()).unwrap();
    // Steps of 0.02 m: 99 of 100, then the robot stands where the last one leads.
    (0..99).for_each(|tick| people.step(&open(), &[NOWHERE], tick));
    let robot = Disc { centre: Point2::new(3.36, 1.0), radius_m: 0.11 };
    (99..150).for_each(|tick| people.step(&open(), &[robot], tick));
    let before = people.bodies()[0].centre;
    assert!((before - Point2::new(2.98, 1.0)).norm() < 1e-9, "{before}");
    people.step(&open(), &[NOWHERE], 150);
    let at = people.bodies()[0].centre;
    assert!((at - Point2::new(3.0, 1.0)).norm() < 1e-9, "{at}");
}

#[test]
fn legs_stand_beside_the_middle_and_swing_with_the_way() {
    let run = RunConfig {
        walkers: vec![walker(&[[0.0, 0.0], [9.0, 0.0]], Shape::Legs)],
        ..config(&open())
    };
    let mut people = People::new(&run, &open()).unwrap();
    let (mut most, mut least) = (f64::NEG_INFINITY, f64::INFINITY);
    for tick in 0..200 {
        people.step(&open(), &[NOWHERE], tick);
        let [left, right] = people.bodies() else { panic!("two legs") };
        assert!((left.centre.y - 0.1).abs() < 1e-12 && (right.centre.y + 0.1).abs() < 1e-12);
        let ahead = left.centre.x - right.centre.x;
        (most, least) = (most.max(ahead), least.min(ahead));
    }
    assert!((most - 0.4).abs() < 0.01 && (least + 0.4).abs() < 0.01, "{most} {least}");
}

#[test]
fn a_crowd_is_that_of_its_seed_and_walks_between_the_walls() {
    let world = apartment();
    let run = |config: &RunConfig| {
        let mut people = People::new(config, &world).unwrap();
        let mut all = Vec::new();
        for tick in 0..3000 {
            people.step(&world, &[NOWHERE], tick);
            all.push(people.bodies().to_vec());
        }
        all
    };
    let first = run(&crowd(8));
    assert_eq!(first, run(&crowd(8)));
    assert_ne!(first[100], run(&RunConfig { seed: 43, ..crowd(8) })[100]);
    let [x_min, y_min, x_max, y_max] = world.bounds();
    let mut way_m = 0.0;
    for bodies in first.windows(2) {
        for (a, b) in bodies[0].iter().zip(&bodies[1]) {
            way_m += length(&(b.centre - a.centre));
            assert!((x_min..=x_max).contains(&b.centre.x) && (y_min..=y_max).contains(&b.centre.y));
            assert!(world.distance_to_nearest(b.centre) > 0.05, "{b:?}");
        }
    }
    // Eight people in a minute, who like 1.34 m/s and wait now and then.
    let speed_m_s = way_m / (8.0 * 60.0);
    assert!((0.5..1.6).contains(&speed_m_s), "{speed_m_s}");
}

#[test]
fn one_person_more_starts_beside_those_there_were() {
    let few = People::new(&crowd(5), &apartment()).unwrap();
    let more = People::new(&crowd(6), &apartment()).unwrap();
    assert_eq!(few.bodies(), &more.bodies()[..5]);
}

#[test]
fn a_crowd_without_room_is_refused_with_its_number() {
    let mut full = crowd(100);
    full.crowd = Some(CrowdConfig { people: 100, radius_m: 2.0, ..CrowdConfig::default() });
    let error = Sim::new(full).unwrap_err().to_string();
    assert!(error.starts_with("crowd.people = 100: "), "{error}");
}

#[test]
fn robot_and_people_stop_each_other_and_do_not_overlap() {
    // The robot drives along x towards a person who walks up and down before it.
    let mut run = config(&open());
    run.start = SE2::new(0.0, 0.0, 0.0);
    run.script = ScriptConfig::Straight { v_m_s: 0.5 };
    run.robot.slip_std = 0.0;
    run.walkers = vec![walker(&[[3.0, 0.0], [0.5, 0.0]], Shape::Disc)];
    let mut sim = Sim::new(run).unwrap();
    let mut frame = Frame::boxed();
    let mut blocked = 0;
    for _ in 0..400 {
        let outcome = sim.step(None, &mut frame);
        blocked += u32::from(outcome == crate::StepOutcome::Blocked);
        let body = sim.bodies()[0];
        let gap_m = length(&(body.centre - Point2::from(sim.truth().translation()))) - 0.36;
        assert!(gap_m >= 0.0, "{gap_m}");
        // Beam 90 looks ahead: the person, less noise.
        if let Some(ranges_m) = frame.ranges_m() {
            assert!((ranges_m[90] - (gap_m + 0.11)).abs() < 0.12, "{} {gap_m}", ranges_m[90]);
        }
    }
    assert!(blocked > 100, "{blocked}");
}

#[test]
fn people_change_no_noise() {
    let scans = |config: RunConfig| {
        let mut sim = Sim::new(config).unwrap();
        let mut frame = Frame::boxed();
        (0..50)
            .filter_map(|_| {
                let _ = sim.step(None, &mut frame);
                frame.ranges_m().map(<[f64]>::to_vec)
            })
            .collect::<Vec<_>>()
    };
    let (without, with) = (scans(config(&apartment())), scans(crowd(20)));
    let (mut same, mut shorter) = (0, 0);
    for (a, b) in without.iter().flatten().zip(with.iter().flatten()) {
        if a == b {
            same += 1;
        } else {
            assert!(b < a, "{a} {b}");
            shorter += 1;
        }
    }
    assert!(shorter > 100 && same > 2 * shorter, "{shorter} of {same}");
}
