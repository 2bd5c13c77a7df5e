//! The book's story of the doors, told by numbers.

use rusty_contract::LidarConfig;
use rusty_geometry::{DiffDrive, Scan, tick_length};

use super::*;
use crate::Random;
use crate::told_tests::told;

fn start() -> Start {
    Start { map: Some(rusty_geometry::hallway().spec().clone()), ..told("bayes-hallway") }
}

/// Middles, m, of the runs of cells with more than half of the mode's mass:
/// those that face east, and those that face west.
fn peaks(filter: &BayesHallway) -> [Vec<f64>; 2] {
    let (belief, cells) = (filter.histogram().cells(), filter.corridor().doors.len());
    let high = 0.5 * belief[filter.histogram().mode()];
    [0..cells, cells..2 * cells].map(|row| {
        let mut found: Vec<[f64; 2]> = Vec::new();
        for k in row.clone() {
            let x_m = filter.x_m(k);
            match (belief[k] > high, k > row.start && belief[k - 1] > high) {
                (true, true) => found.last_mut().unwrap()[1] = x_m,
                (true, false) => found.push([x_m, x_m]),
                _ => {}
            }
        }
        found.into_iter().map(|[a, b]| 0.5 * (a + b)).collect()
    })
}

#[test]
fn the_map_s_doors_are_where_they_are() {
    let corridor = Corridor::new(rusty_geometry::hallway().spec(), 0.05).unwrap();
    assert_eq!((corridor.doors.len(), corridor.from_x_m), (240, 0.0));
    assert!((corridor.middle_y_m - 0.8).abs() < 1e-9 && (corridor.width_m - 1.6).abs() < 1e-9);
    for (cell, [north, south]) in corridor.doors.iter().enumerate() {
        let x_m = corridor.x_m(cell);
        let edge_m = [1.5, 2.5, 4.1, 5.1, 8.5, 9.5]
            .iter()
            .fold(f64::INFINITY, |near: f64, edge| near.min((x_m - edge).abs()));
        let door = [2.0, 4.6, 9.0].iter().any(|middle: &f64| (x_m - middle).abs() < 0.5);
        assert_eq!(*south, 0.0);
        // A stretch that is half a door is either.
        assert!(edge_m < 0.051 || *north == f64::from(u8::from(door)), "{x_m}: {north}");
    }
    // Both sides, both headings, by hand: right 19 times in 20.
    let door = Doors { left: Some(true), right: Some(false) };
    let at = |x_m: f64, east| corridor.likelihood(&door, (x_m / 0.05) as usize, east, 0.05);
    assert!((at(2.0, true) - 0.95 * 0.95).abs() < 1e-12);
    assert!((at(3.0, true) - 0.05 * 0.95).abs() < 1e-12);
    assert!((at(2.0, false) - 0.05 * 0.05).abs() < 1e-12);
    assert!((at(3.0, false) - 0.05 * 0.95).abs() < 1e-12);
    assert_eq!(corridor.likelihood(&Doors::default(), 3, true, 0.05), 1.0);
}

#[test]
fn three_peaks_until_the_way_tells_the_doors_apart() {
    let mut filter = BayesHallway::new(&start(), &Options::default()).unwrap();
    assert!(filter.histogram().cells().iter().all(|mass| *mass == 1.0 / 480.0));
    let counts_per_m = 1.0 / tick_length(&DiffDrive::rusty());
    let (mut way_m, mut after_one, mut after_two) = (0.0, None, None);
    // Seven looks at a wall, ten at a door, and so on, as from x = 0.8 on.
    for look in 0..50 {
        let x_m = 0.85 + 0.1 * f64::from(look);
        let door = [2.0, 4.6, 9.0].iter().any(|middle| f64::abs(x_m - middle) < 0.5);
        filter.see(&Doors { left: Some(door), right: Some(false) });
        match look {
            12 => after_one = Some(peaks(&filter)),
            40 => after_two = Some(peaks(&filter)),
            _ => {}
        }
        for _ in 0..10 {
            way_m += 0.01;
            let counts = (way_m * counts_per_m) as i64;
            filter.advance(EncoderCounts { left: counts, right: counts });
        }
        let sum: f64 = filter.histogram().cells().iter().sum();
        assert!((sum - 1.0).abs() < 1e-12);
    }
    // Half a metre behind the beginning of a door: one of the three.
    let [east, west] = after_one.unwrap();
    assert_eq!((east.len(), west.len()), (3, 0), "{east:?} {west:?}");
    for (peak_m, expected_m) in east.iter().zip([2.05, 4.65, 9.05]) {
        assert!((peak_m - expected_m).abs() < 0.15, "{east:?}");
    }
    // 2.6 m from one to the next: only the first two are that near to each other.
    let [east, west] = after_two.unwrap();
    assert_eq!((east.len(), west.len()), (1, 0), "{east:?} {west:?}");
    assert!((east[0] - 4.85).abs() < 0.1, "{east:?}");
}

/// A robot that slips, what its laser reads, and the filter.
struct Drive {
    pose: SE2,
    filter: BayesHallway,
    random: Random,
    scan: Scan,
    /// Ways of the wheels in counts, left and right.
    counts: [f64; 2],
    tick: u64,
}

impl Drive {
    fn from(seed: u64, pose: SE2) -> Self {
        let filter = BayesHallway::new(&start(), &Options::default()).unwrap();
        let (random, scan) = (Random::new(seed, 9), Scan::new(LidarConfig::default().fan()));
        Self { pose, filter, random, scan, counts: [0.0; 2], tick: 0 }
    }

    /// N ticks, the wheels going these ways (m) in each.
    fn go(&mut self, ticks: u64, ways_m: [f64; 2]) {
        let (world, config) = (rusty_geometry::hallway(), LidarConfig::default());
        let mut ranges_m = vec![0.0; config.beams as usize];
        let drive = DiffDrive::rusty();
        for _ in 0..ticks {
            let random = &mut self.random;
            let [left, right] = ways_m.map(|way_m| way_m * (1.0 + 0.02 * random.normal()));
            self.pose = self.pose.boxplus(&drive.tangent(left, right));
            self.counts[0] += ways_m[0] / tick_length(&drive);
            self.counts[1] += ways_m[1] / tick_length(&drive);
            let [left, right] = self.counts.map(|count| count as i64);
            self.filter.advance(EncoderCounts { left, right });
            if self.tick.is_multiple_of(5) {
                self.scan.take(&world, &self.pose, config.range_max_m);
                self.scan.write_distances_m(&mut ranges_m);
                ranges_m.iter_mut().for_each(|range_m| {
                    *range_m = (*range_m + 0.02 * random.normal()).min(config.range_max_m);
                    if random.uniform() < 0.02 {
                        *range_m = config.range_max_m;
                    }
                });
                self.filter.scan(&ranges_m);
            }
            self.tick += 1;
        }
    }
}

/// A robot drives ten metres; where it is at the end, and the filter.
fn drive(seed: u64, from: SE2) -> (SE2, BayesHallway) {
    let mut drive = Drive::from(seed, from);
    drive.go(1000, [0.01; 2]);
    (drive.pose, drive.filter)
}

#[test]
fn who_turns_about_is_not_lost() {
    // Six metres on, about on the spot either way round, and a part of the way back.
    for (seed, from, turn_m) in [
        (3, SE2::new(0.8, 0.8, 0.0), 0.002),
        (4, SE2::new(0.8, 0.8, 0.0), -0.002),
        (5, SE2::new(11.2, 0.8, PI), 0.002),
    ] {
        let mut drive = Drive::from(seed, from);
        drive.go(600, [0.01; 2]);
        let half_turn = PI * 0.5 * DiffDrive::rusty().track_m;
        let ticks = (half_turn / f64::abs(turn_m)) as u64;
        drive.go(ticks, [-turn_m, turn_m]);
        for _ in 0..4 {
            drive.go(75, [0.01; 2]);
            let (found, covariance) = drive.filter.estimate();
            let tau = drive.pose.boxminus(&found);
            assert!(
                tau.x.abs() < 0.2 && tau.y.abs() < 0.05 && tau.z.abs() < 0.05,
                "seed {seed}: {tau}, {:?} for {:?}",
                found,
                drive.pose
            );
            assert!(tau.x * tau.x < 9.0 * covariance[(0, 0)], "seed {seed}: {covariance}");
        }
    }
}

#[test]
fn a_look_that_sees_nothing_is_none() {
    let mut filter = BayesHallway::new(&start(), &Options::default()).unwrap();
    filter.see(&Doors::default());
    assert!(filter.since_look_m >= LOOK_EVERY_M);
    filter.see(&Doors { left: None, right: Some(false) });
    assert_eq!(filter.since_look_m, 0.0);
}

#[test]
fn the_way_since_the_last_look_is_in_doubt_too() {
    let mut filter = BayesHallway::new(&start(), &Options::default()).unwrap();
    let before = filter.estimate().1[(0, 0)];
    filter.rest_variance = 0.25;
    assert!((filter.estimate().1[(0, 0)] - before - 0.25).abs() < 1e-12);
    // As far as numbers go, and back: no overflow.
    filter.advance(EncoderCounts { left: i64::MIN, right: i64::MIN });
    assert!((filter.histogram().cells().iter().sum::<f64>() - 1.0).abs() < 1e-9);
}

#[test]
fn it_finds_a_robot_that_faces_either_way() {
    for (seed, from) in [(1, SE2::new(0.8, 0.8, 0.0)), (2, SE2::new(11.2, 0.8, PI))] {
        let (truth, filter) = drive(seed, from);
        let (found, covariance) = filter.estimate();
        let tau = truth.boxminus(&found);
        assert!(tau.x.abs() < 0.15 && tau.y.abs() < 0.05 && tau.z.abs() < 0.05, "{tau} {truth:?}");
        assert_eq!(covariance, covariance.transpose());
        assert!(covariance.iter().all(|v| v.is_finite()) && covariance[(0, 0)] < 0.2 * 0.2);
        let again = drive(seed, from).1;
        assert_eq!(again.histogram(), filter.histogram());
        let mut poses = Vec::new();
        assert_eq!(filter.belief(&mut poses), Some(BeliefKind::Histogram));
        assert!((poses.iter().map(|pose| pose.weight).sum::<f64>() - 1.0).abs() < 1e-12);
    }
}

#[test]
fn nonsense_is_refused_or_borne() {
    let refused =
        |start: &Start| BayesHallway::new(start, &Options::default()).err().unwrap().to_string();
    let said = refused(&Start { map: None, ..start() });
    assert!(said.contains("map = \"given\""), "{said}");
    let mut plan = rusty_geometry::hallway().spec().clone();
    plan.walls.retain(|wall| wall.a[1] < 1.0 || wall.b[1] < 1.0);
    for plan in [plan, rusty_geometry::open().spec().clone()] {
        let said = refused(&Start { map: Some(plan), ..start() });
        assert!(said.contains("\"hallway\""), "{said}");
    }
    let mut filter = BayesHallway::new(&start(), &Options::default()).unwrap();
    for ranges_m in [vec![], vec![f64::NAN; 180], vec![8.0; 180], vec![0.0; 180], vec![1.0; 7]] {
        filter.scan(&ranges_m);
        let (pose, covariance) = filter.estimate();
        assert!(pose.is_finite() && covariance.iter().all(|v| v.is_finite()));
    }
}
