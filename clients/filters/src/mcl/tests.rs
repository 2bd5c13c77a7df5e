//! A robot without slip in the Apartment, and a laser with noise: made here, for
//! filters cannot name the simulator.

use super::*;
use crate::OccupancyMap;
use crate::moment::Moment;
use crate::occupancy::Cell;
use crate::scan_match::tests::world_of;
use rusty_contract::config::LidarConfig;
use rusty_geometry::{DiffDrive, Scan, World, odometry_delta};

/// A robot that drives an arc, and its laser.
struct Drive {
    world: World,
    robot: Robot,
    scan: Scan,
    truth: SE2,
    ticks: EncoderCounts,
    random: Random,
    tick: u64,
    ranges_m: Vec<f64>,
}

impl Drive {
    fn from(truth: SE2) -> Self {
        Self::within(rusty_geometry::apartment(), truth)
    }

    fn within(world: World, truth: SE2) -> Self {
        let lidar = LidarConfig { dropout: 0.02, ..LidarConfig::default() };
        let robot = Robot { drive: DiffDrive::rusty(), body_radius_m: 0.11, lidar, dt_s: 0.1 };
        Self {
            world,
            robot,
            scan: Scan::new(lidar.fan()),
            truth,
            ticks: EncoderCounts::default(),
            random: Random::new(99, 99),
            tick: 0,
            ranges_m: vec![0.0; 180],
        }
    }

    fn mcl(&self, initial: Option<SE2>, options: &Options) -> Mcl {
        Mcl::new(self.robot, Map::Plan(Box::new(self.world.clone())), initial, options).unwrap()
    }

    /// A tick of 0.1 s in which it drives on, and a scan at its end.
    fn step(&mut self, mcl: &mut Mcl) {
        self.turn_wheels(mcl, [500, 620]);
    }

    /// The same, the wheels turning by these counts.
    fn turn_wheels(&mut self, mcl: &mut Mcl, [left, right]: [i64; 2]) {
        let before = self.ticks;
        self.ticks.left += left;
        self.ticks.right += right;
        let step = odometry_delta(before, self.ticks, &self.robot.drive);
        self.truth = self.truth.boxplus(&step);
        let max_m = self.robot.lidar.range_max_m;
        self.scan.take(&self.world, &self.truth, max_m);
        self.scan.write_distances_m(&mut self.ranges_m);
        for range_m in &mut self.ranges_m {
            let noise_m = self.robot.lidar.range_std_m * self.random.normal();
            let lost = self.random.uniform() < self.robot.lidar.dropout;
            *range_m = if lost { max_m } else { (*range_m + noise_m).clamp(0.0, max_m) };
        }
        self.tick += 1;
        mcl.advance(0.1 * self.tick as f64, self.ticks);
        mcl.scan(&self.ranges_m);
    }
}

fn error(mcl: &Mcl, truth: &SE2) -> Option<Vector3<f64>> {
    Some(truth.boxminus(&mcl.answer()?.pose_in_world))
}

#[test]
fn it_finds_itself_keeps_to_that_and_finds_itself_again() {
    let mut drive = Drive::from(SE2::new(9.6, 3.0, 0.4));
    let options = Options { particles: 3000, ..Options::default() };
    let mut mcl = drive.mcl(None, &options);
    drive.step(&mut mcl);
    assert_eq!(mcl.answer(), None, "one scan is not enough");
    (0..30).for_each(|_| drive.step(&mut mcl));
    let tau = error(&mcl, &drive.truth).unwrap();
    assert!(tau.norm() < 0.02, "{tau}");
    assert_eq!(mcl.particles().count(), 1000, "few are enough for one place");
    drive.truth = SE2::new(1.6, 6.6, -1.2);
    (0..10).for_each(|_| drive.step(&mut mcl));
    assert_eq!(mcl.answer(), None, "it has noticed");
    (0..90).for_each(|_| drive.step(&mut mcl));
    let tau = error(&mcl, &drive.truth).unwrap();
    assert!(tau.norm() < 0.02, "{tau}");
}

#[test]
fn the_beam_model_finds_and_keeps_it_too() {
    let mut drive = Drive::from(SE2::new(9.6, 3.0, 0.4));
    let (particles, particles_min) = (2000, Some(300));
    let options = Options { model: Model::Beam, particles, particles_min, ..Options::default() };
    let mut mcl = drive.mcl(None, &options);
    (0..20).for_each(|_| drive.step(&mut mcl));
    let tau = error(&mcl, &drive.truth).unwrap();
    assert!(tau.norm() < 0.02, "{tau}");
}

#[test]
fn the_same_again_has_the_same_bits() {
    let run = |seed| {
        let mut drive = Drive::from(SE2::new(9.6, 3.0, 0.4));
        let options = Options { seed, particles: 2000, ..Options::default() };
        let mut mcl = drive.mcl(None, &options);
        (0..20).for_each(|_| drive.step(&mut mcl));
        let estimate = mcl.answer().unwrap();
        estimate.covariance.unwrap().map(f64::to_bits).to_vec()
    };
    assert_eq!(run(1), run(1));
    assert_ne!(run(1), run(2));
}

#[test]
fn between_scans_the_wheels_carry_the_answer_on() {
    let mut drive = Drive::from(SE2::new(9.6, 3.0, 0.4));
    let mut mcl = drive.mcl(Some(drive.truth), &Options::default());
    (0..3).for_each(|_| drive.step(&mut mcl));
    let before = mcl.answer().unwrap();
    let was = drive.ticks;
    let ticks = EncoderCounts { left: was.left + 4000, right: was.right + 4200 };
    mcl.advance(1.0, ticks);
    let after = mcl.answer().unwrap();
    let step = odometry_delta(was, ticks, &drive.robot.drive);
    // As far as the wheels say, times what was learned of them.
    let wheels = Motion { now_in_then: SE2::identity().boxplus(&step), ..Motion::default() };
    let said = before.pose_in_world * mcl.particles().scaled(&wheels).now_in_then;
    assert!(after.pose_in_world.boxminus(&said).norm() < 1e-12);
    assert!(after.pose_in_world.boxminus(&before.pose_in_world.boxplus(&step)).norm() < 0.02);
    let (a, b) = (before.covariance.unwrap(), after.covariance.unwrap());
    assert!(b[0] > a[0] && b[8] > a[8], "{a:?}, {b:?}");
    let p = Matrix3::from_row_slice(&b);
    assert!(p == p.transpose() && p.cholesky().is_some(), "{p}");
}

#[test]
fn asleep_it_counts_and_says_nothing() {
    let mut drive = Drive::from(SE2::new(9.6, 3.0, 0.4));
    let options = Options { from: Moment::Seconds(0.95), ..Options::default() };
    let mut mcl = drive.mcl(Some(drive.truth), &options);
    for _ in 0..9 {
        drive.step(&mut mcl);
        assert_eq!(mcl.answer(), None, "{}", drive.tick);
    }
    drive.step(&mut mcl);
    let tau = error(&mcl, &drive.truth).unwrap();
    assert!(tau.norm() < 0.03, "{tau}");
}

#[test]
fn scans_of_nothing_and_of_nonsense_are_borne() {
    let mut drive = Drive::from(SE2::new(9.6, 3.0, 0.4));
    for (model, initial) in
        [(Model::Field, Some(drive.truth)), (Model::Beam, Some(drive.truth)), (Model::Field, None)]
    {
        let options =
            Options { model, particles: 300, particles_min: Some(100), ..Options::default() };
        let mut mcl = drive.mcl(initial, &options);
        let bad =
            [vec![], vec![8.0; 180], vec![f64::NAN; 180], vec![1e300; 180], vec![1e-300; 500]];
        for (k, ranges_m) in bad.iter().enumerate() {
            mcl.advance(k as f64, EncoderCounts { left: 1 << 50, right: -(1 << 50) });
            mcl.scan(ranges_m);
            if let Some(answer) = mcl.answer() {
                assert!(Reply::Estimate(answer).check().is_ok(), "{k}: {answer:?}");
            }
        }
        drive.step(&mut mcl);
    }
}

/// NEES of an answer.
fn nees(mcl: &Mcl, truth: &SE2) -> f64 {
    let p = Matrix3::from_row_slice(&mcl.answer().unwrap().covariance.unwrap());
    let tau = error(mcl, truth).unwrap();
    tau.dot(&(p.cholesky().unwrap().inverse() * tau))
}

#[test]
fn a_minute_in_one_place_says_no_more_than_it_can() {
    let (mut sum, robots) = (0.0, 8);
    for k in 0..robots {
        let mut drive = Drive::from(SE2::new(9.6, 3.0, 0.4 + 0.3 * f64::from(k)));
        drive.random = Random::new(k as u64, 99);
        let options = Options { seed: k as u64, particles: 2000, ..Options::default() };
        let mut mcl = drive.mcl(Some(drive.truth), &options);
        (0..40).for_each(|_| drive.turn_wheels(&mut mcl, [0, 0]));
        let settled = mcl.answer().unwrap();
        // A count to and fro is no motion. Once is enough for a whole minute of it.
        let steps = if k == 0 { 560 } else { 100 };
        (0..steps).for_each(|step| {
            let count = if step % 2 == 0 { 1 } else { -1 };
            drive.turn_wheels(&mut mcl, [count, -count]);
        });
        let after = mcl.answer().unwrap();
        let (was, is) = (settled.covariance.unwrap(), after.covariance.unwrap());
        for i in [0, 4, 8] {
            let ratio = is[i] / was[i];
            assert!((0.9..1.5).contains(&ratio), "robot {k}, {i}: {ratio}");
        }
        assert!(is[0].sqrt() > 3e-4, "robot {k}: {} m", is[0].sqrt());
        sum += nees(&mcl, &drive.truth);
    }
    // χ² with 24 degrees, 1 in 2000 at either end.
    assert!((8.0..54.0).contains(&sum), "{sum}");
}

#[test]
fn standing_it_finds_itself_too_and_misses_itself() {
    let mut drive = Drive::from(SE2::new(9.6, 3.0, 0.4));
    let mut mcl = drive.mcl(None, &Options { particles: 3000, ..Options::default() });
    let mut known = 0;
    for _ in 0..100 {
        drive.turn_wheels(&mut mcl, [0, 0]);
        if let Some(tau) = error(&mcl, &drive.truth) {
            known += 1;
            assert!(tau.norm() < 0.1, "{tau}");
        }
    }
    assert!(known > 50, "{known} answers");
    assert!(nees(&mcl, &drive.truth) < 20.0);
    // Carried away, its wheels still.
    drive.truth = SE2::new(1.6, 6.6, -1.2);
    (0..10).for_each(|_| drive.turn_wheels(&mut mcl, [0, 0]));
    assert_eq!(mcl.answer(), None, "it has noticed");
    (0..60).for_each(|_| drive.turn_wheels(&mut mcl, [0, 0]));
    let tau = error(&mcl, &drive.truth).unwrap();
    assert!(tau.norm() < 0.02, "{tau}");
}

#[test]
fn driving_its_errors_are_as_large_as_it_says() {
    let (mut sum, mut count, robots) = (0.0, 0.0, 10);
    for k in 0..robots {
        let mut drive = Drive::from(SE2::new(9.6, 3.0, 0.4));
        drive.random = Random::new(k, 98);
        let options = Options { seed: k, particles: 1000, ..Options::default() };
        let mut mcl = drive.mcl(Some(drive.truth), &options);
        (0..20).for_each(|_| drive.step(&mut mcl));
        for _ in 0..20 {
            drive.step(&mut mcl);
            sum += nees(&mcl, &drive.truth);
            count += 1.0;
        }
    }
    // Wheels that do not slip are better than it believes: 3 at the most. Errors
    // of one drive hang together, so it is not told more narrowly.
    let mean = sum / count;
    assert!((1.0..4.0).contains(&mean), "{mean}");
}

#[test]
fn it_stays_where_it_is_while_something_holds_it_and_its_wheels_turn() {
    for k in 0..8 {
        let mut drive = Drive::from(SE2::new(9.6, 3.0, 0.4));
        drive.random = Random::new(k, 97);
        let options = Options { seed: k, particles: 1000, ..Options::default() };
        let mut mcl = drive.mcl(Some(drive.truth), &options);
        (0..10).for_each(|_| drive.step(&mut mcl));
        for wheels in [[500, 620], [600, 600], [0, 700], [-500, -500]] {
            let stands = drive.truth;
            for _ in 0..20 {
                drive.truth = stands.boxplus(&-odometry_delta(
                    EncoderCounts::default(),
                    EncoderCounts { left: wheels[0], right: wheels[1] },
                    &drive.robot.drive,
                ));
                drive.turn_wheels(&mut mcl, wheels);
                let tau = error(&mcl, &drive.truth).unwrap();
                assert!(tau.norm() < 0.08, "robot {k}, wheels {wheels:?}: {tau}");
            }
            (0..5).for_each(|_| drive.step(&mut mcl));
        }
    }
}

#[test]
fn few_particles_are_the_fewest_and_more_of_them_are_refused() {
    let options = Options { particles: 500, ..Options::default() };
    assert_eq!((options.least(), Options::default().least()), (500, 1000));
    let mut drive = Drive::from(SE2::new(9.6, 3.0, 0.4));
    let mut mcl = drive.mcl(Some(drive.truth), &options);
    (0..5).for_each(|_| drive.step(&mut mcl));
    assert_eq!(mcl.particles().count(), 500);
    let options = Options { particles_min: Some(501), ..options };
    let map = Map::Plan(Box::new(drive.world.clone()));
    let refused = Mcl::new(drive.robot, map, None, &options).unwrap_err().to_string();
    assert!(refused.contains("--particles-min 501 is more than --particles 500"), "{refused}");
}

#[test]
fn without_a_map_that_serves_it_says_what_is_wrong() {
    let robot = Drive::from(SE2::identity()).robot;
    let cells = OccupancyMap::of_world(&rusty_geometry::apartment(), 0.1, 0.05);
    let beam = Options { model: Model::Beam, ..Options::default() };
    let refused = Mcl::new(robot, Map::Cells(cells.clone()), None, &beam).unwrap_err().to_string();
    assert!(refused.contains("--model field"), "{refused}");
    let unknown = OccupancyMap::unknown(cells.frame);
    let nowhere = Mcl::new(robot, Map::Cells(unknown), None, &Options::default()).unwrap_err();
    assert!(nowhere.to_string().contains("no place where a body of 0.11 m"), "{nowhere}");
}

#[test]
fn a_map_of_cells_serves_as_well() {
    let mut drive = Drive::from(SE2::new(9.6, 3.0, 0.4));
    let cells = OccupancyMap::of_world(&drive.world, 0.1, 0.05);
    let mut mcl = Mcl::new(drive.robot, Map::Cells(cells), None, &Options::default()).unwrap();
    (0..60).for_each(|_| drive.step(&mut mcl));
    let tau = error(&mcl, &drive.truth).unwrap();
    // Half a cell: on which side of its wall a cell lies is unknown.
    assert!(tau.norm() < 0.06, "{tau}");
}

/// Six corridors of 40 m with alcoves of various widths and depths on both sides. In every
/// second one is a box that is not on the map.
fn building(is_mapped: bool) -> World {
    let (mut random, mut walls) = (Random::new(5, 5), Vec::new());
    let mut wall = |a: [f64; 2], b: [f64; 2]| walls.push([a[0], a[1], b[0], b[1]]);
    for (corridor, side) in (0..6).flat_map(|corridor| [(corridor, -1.0), (corridor, 1.0)]) {
        let y_m = |from_middle_m: f64| 8.0 * f64::from(corridor) + 4.0 + side * from_middle_m;
        let (mut x_m, mut at_m, mut count) = (0.0, 0.0, 0);
        while x_m < 40.0 {
            let next_m = x_m + 1.5 + 2.0 * random.uniform();
            let next_m = if next_m > 38.5 { 40.0 } else { next_m };
            let deep_m = 1.0 + 2.5 * random.uniform();
            wall([x_m, y_m(at_m)], [x_m, y_m(deep_m)]);
            wall([x_m, y_m(deep_m)], [next_m, y_m(deep_m)]);
            if !is_mapped && count % 2 == 0 {
                let (from, to) = ([x_m + 0.4, y_m(0.5)], [x_m + 0.9, y_m(0.8)]);
                wall(from, [to[0], from[1]]);
                wall([to[0], from[1]], to);
            }
            (x_m, at_m, count) = (next_m, deep_m, count + 1);
        }
        wall([40.0, y_m(at_m)], [40.0, y_m(0.0)]);
    }
    world_of([0.0, 0.0, 40.0, 48.0], &walls)
}

#[test]
fn in_a_large_building_with_things_that_are_not_on_the_map_it_finds_itself() {
    for (corridor, x_m) in [(1, 8.0), (4, 14.0)] {
        let start = SE2::new(x_m, 8.0 * f64::from(corridor) + 4.0, 0.0);
        let mut drive = Drive::within(building(false), start);
        let options = Options { particles: 1000, ..Options::default() };
        let plan = Map::Plan(Box::new(building(true)));
        let mut mcl = Mcl::new(drive.robot, plan, None, &options).unwrap();
        for _ in 0..300 {
            drive.turn_wheels(&mut mcl, [560, 560]);
            if let Some(tau) = error(&mcl, &drive.truth) {
                assert!(tau.norm() < 0.05, "{corridor}: {tau}");
            }
        }
        assert!(mcl.answer().is_some(), "{corridor}");
    }
}

#[test]
fn beyond_the_walls_of_its_map_it_abstains_and_back_among_them_it_is_found() {
    // The map ends after 20 m.
    let mut map = OccupancyMap::of_world(&building(true), 0.1, 0.05);
    for (cell, what) in map.cells.iter_mut().enumerate() {
        if cell % map.frame.width > 400 {
            *what = Cell::Unknown;
        }
    }
    for corridor in [1, 2, 4] {
        let start = SE2::new(8.0, 8.0 * f64::from(corridor) + 4.0, 0.0);
        let mut drive = Drive::within(building(true), start);
        let options = Options { particles: 1000, ..Options::default() };
        let map = Map::Cells(map.clone());
        let mut mcl = Mcl::new(drive.robot, map, Some(start), &options).unwrap();
        let mut step = |counts, slip_m| {
            drive.turn_wheels(&mut mcl, [counts, counts]);
            let slip_m = if drive.truth.x() > 20.0 { slip_m } else { 0.0 };
            drive.truth = drive.truth.boxplus(&Vector3::new(slip_m, 0.0, 0.0));
            let tau = error(&mcl, &drive.truth);
            assert!(tau.is_none_or(|tau| tau.norm() < 0.5), "{corridor}: {tau:?}");
            tau
        };
        // A fifth of the way out is slip.
        (0..170).for_each(|_| _ = step(2800, -0.03));
        assert_eq!(step(2800, -0.03), None, "{corridor}: ten metres beyond it");
        (0..150).for_each(|_| _ = step(-2800, 0.0));
        let tau = step(-2800, 0.0).unwrap();
        assert!(tau.norm() < 0.05, "{corridor}: {tau}");
    }
}
