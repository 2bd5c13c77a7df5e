//! A robot without slip and a laser with noise, made here: filters cannot name the simulator.

use super::*;
use crate::Random;
use crate::told_tests::told;
use rusty_contract::LidarConfig;
use rusty_geometry::{DiffDrive, Scan, odometry_delta};

struct Drive {
    world: World,
    scan: Scan,
    truth: SE2,
    counts: EncoderCounts,
    random: Random,
    filter: GridLocalisation,
}

impl Drive {
    fn new(world: World, truth: SE2, initial_pose: Option<SE2>) -> Self {
        let map = Some(world.spec().clone());
        let start = Start { map, initial_pose, ..told("grid-localisation") };
        let filter = GridLocalisation::new(&start, &Options::default()).unwrap();
        let (scan, counts) = (Scan::new(LidarConfig::default().fan()), EncoderCounts::default());
        Self { world, scan, truth, counts, random: Random::new(99, 99), filter }
    }

    fn ranges_m(&mut self, std_m: f64) -> Vec<f64> {
        let max_m = LidarConfig::default().range_max_m;
        let mut ranges_m = vec![0.0; 180];
        self.scan.take(&self.world, &self.truth, max_m);
        self.scan.write_distances_m(&mut ranges_m);
        for range_m in &mut ranges_m {
            *range_m = (*range_m + std_m * self.random.normal()).clamp(0.0, max_m);
        }
        ranges_m
    }

    /// A piece of an arc, and a scan at its end.
    fn step(&mut self) {
        let before = self.counts;
        self.counts.left += 500;
        self.counts.right += 620;
        let step = odometry_delta(before, self.counts, &DiffDrive::rusty());
        self.truth = self.truth.boxplus(&step);
        let ranges_m = self.ranges_m(0.02);
        self.filter.advance(self.counts);
        self.filter.scan(&ranges_m);
    }

    /// Position error, m, and heading error, rad, of the answer.
    fn error(&self) -> Option<(f64, f64)> {
        let tau = self.truth.boxminus(&self.filter.answer()?.pose_in_world);
        Some((tau.xy().norm(), tau.z.abs()))
    }
}

#[test]
fn it_finds_itself_and_finds_itself_again() {
    for start in [SE2::new(9.6, 3.0, 0.4), SE2::new(2.0, 2.0, 2.0), SE2::new(5.0, 6.5, -1.0)] {
        let mut drive = Drive::new(rusty_geometry::apartment(), start, None);
        drive.step();
        assert_eq!(drive.filter.answer(), None, "one scan is not enough");
        (0..60).for_each(|_| drive.step());
        let (off_m, off_rad) = drive.error().unwrap_or((f64::NAN, 0.0));
        assert!(off_m < 0.15 && off_rad < 0.09, "{start:?}: {off_m} m, {off_rad} rad");
        drive.truth = SE2::new(1.6, 6.6, -1.2);
        (0..80).for_each(|_| drive.step());
        let (off_m, off_rad) = drive.error().unwrap_or((f64::NAN, 0.0));
        assert!(off_m < 0.15 && off_rad < 0.09, "{start:?}: {off_m} m, {off_rad} rad");
    }
}

#[test]
fn a_scan_makes_the_cell_that_it_was_taken_in_the_heaviest() {
    let world = rusty_geometry::apartment();
    for (column, row, layer) in [(63, 20, 7), (12, 13, 40), (35, 44, 66), (70, 10, 0)] {
        let centre = SE2::new(
            (f64::from(column) + 0.5) * 0.15,
            (f64::from(row) + 0.5) * 0.15,
            f64::from(layer) * 5.0_f64.to_radians(),
        );
        let mut drive = Drive::new(world.clone(), centre, None);
        let ranges_m = drive.ranges_m(0.0);
        drive.filter.scan(&ranges_m);
        let likely = &drive.filter.likely;
        let most = |k: &usize, l: &usize| likely.weights[*k].total_cmp(&likely.weights[*l]);
        let off = |k: &usize| likely.pose(*k).boxminus(&centre).norm();
        let here = (0..likely.count()).filter(|k| off(k) < 1.0).max_by(most).unwrap();
        assert!(off(&here) < 1e-9, "{centre:?}: {}", off(&here));
        // Elsewhere a mode that explains the scan as well may be as heavy.
        let elsewhere = (0..likely.count()).max_by(most).unwrap();
        let ratio = likely.weights[elsewhere] / likely.weights[here];
        assert!(ratio < 1.35, "{centre:?}: {ratio}");
    }
}

#[test]
fn between_two_rooms_that_look_the_same_it_does_not_answer() {
    let world = rusty_geometry::place("twin-rooms").unwrap();
    for start in [SE2::new(2.2, 2.4, 0.4), SE2::new(2.0, 2.5, 1.3)] {
        let mut drive = Drive::new(world.clone(), start, None);
        for k in 0..80 {
            drive.step();
            assert_eq!(drive.filter.answer(), None, "{start:?}, scan {k}");
        }
        let mode = drive.filter.modes.heaviest(&drive.filter.likely).unwrap();
        assert!(mode.share < 0.95 && mode.share + mode.second_share > 0.95, "{mode:?}");
        // Told where it begins, it knows.
        let mut drive = Drive::new(world.clone(), start, Some(start));
        (0..80).for_each(|_| drive.step());
        assert!(drive.error().unwrap().0 < 0.15, "{start:?}: {:?}", drive.error());
    }
}

#[test]
fn the_same_again_has_the_same_bits_and_a_scan_at_rest_is_not_used() {
    let run = || {
        let mut drive = Drive::new(rusty_geometry::apartment(), SE2::new(9.6, 3.0, 0.4), None);
        (0..20).for_each(|_| drive.step());
        let once = drive.filter.answer().unwrap();
        let ranges_m = drive.ranges_m(0.02);
        (0..5).for_each(|_| drive.filter.scan(&ranges_m));
        assert_eq!(drive.filter.answer(), Some(once));
        let mut poses = Vec::new();
        assert_eq!(drive.filter.belief(&mut poses), Some(BeliefKind::Histogram));
        let sum: f64 = poses.iter().map(|pose| pose.weight).sum();
        assert!((0.95..=1.0 + 1e-12).contains(&sum), "{sum}");
        once.covariance.unwrap().map(f64::to_bits).to_vec()
    };
    assert_eq!(run(), run());
}

#[test]
fn at_an_initial_pose_it_answers_at_once_and_says_what_it_cannot_use() {
    let truth = SE2::new(9.6, 3.0, 0.4);
    let mut drive = Drive::new(rusty_geometry::apartment(), truth, Some(truth));
    assert_eq!(drive.error(), Some((0.0, 0.0)));
    for ranges_m in [vec![], vec![f64::NAN; 180], vec![8.0; 180], vec![0.0; 180]] {
        drive.filter.scan(&ranges_m);
        assert_eq!(drive.error(), Some((0.0, 0.0)));
    }
    (0..20).for_each(|_| drive.step());
    assert!(drive.error().unwrap().0 < 0.15, "{:?}", drive.error());

    let refused = |start: &Start, cell_m: f64| {
        let options = Options { cell_m, ..Options::default() };
        GridLocalisation::new(start, &options).err().unwrap().to_string()
    };
    let start = told("grid-localisation");
    assert!(refused(&start, 0.15).contains("map = \"given\""));
    let large = rusty_geometry::place("warehouse").unwrap().spec().clone();
    let said = refused(&Start { map: Some(large), ..start }, 0.02);
    assert!(said.contains("a larger --cell-m than 0.02"), "{said}");
    assert!(side("0").is_err() && turn("90").is_err() && turn("10") == Ok(10.0));
}
