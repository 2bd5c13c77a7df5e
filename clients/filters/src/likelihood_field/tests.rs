//! The field against the book's mixture, cell by cell.

use super::*;
use crate::scan_match::tests::world_of;

const RANGE_MAX_M: f64 = 8.0;

fn model() -> BeamModel {
    BeamModel {
        z_hit: 0.9,
        z_short: 0.02,
        z_max: 0.02,
        z_rand: 0.06,
        sigma_hit_m: 0.05,
        lambda_short_per_m: 1.0,
    }
}

/// One wall along x = 1.
fn one_wall() -> World {
    world_of([0.0, 0.0, 2.0, 2.0], &[[1.0, 0.0, 1.0, 2.0]])
}

/// Table 6.3, line 8, of readings that are not z_max.
fn by_the_book(distance_m: f64, sigma_m: f64) -> f64 {
    let z = distance_m / sigma_m;
    let normal = trig::exp(-0.5 * z * z) / ((2.0 * PI).sqrt() * sigma_m);
    trig::ln((0.9 * normal + 0.08 / RANGE_MAX_M) / 0.98)
}

#[test]
fn every_cell_has_the_logarithm_of_the_book_s_mixture() {
    let field = LikelihoodField::of_world(&one_wall(), &model(), RANGE_MAX_M, 0.0, 0.01);
    let mut ends = Ends::default();
    let mut worst = 0.0_f64;
    for column in 0..200 {
        let x_m = 0.01 * f64::from(column) + 0.005;
        ends.set(std::iter::once(Point2::new(x_m, 1.005)));
        let found = field.log_likelihood(&ends, &SE2::identity());
        let said = by_the_book((x_m - 1.0).abs(), field.sigma_m());
        worst = worst.max((found - said).abs());
    }
    // Half a step, and what f32 leaves of a distance.
    assert!(worst <= 0.5 * field.step_log + 1e-4, "{worst}, a step is {}", field.step_log);
    assert!(field.step_log < 0.03, "{}", field.step_log);
}

#[test]
fn a_scan_is_the_sum_of_its_ends_wherever_the_body_stands() {
    let world = rusty_geometry::apartment();
    let field = LikelihoodField::of_world(&world, &model(), RANGE_MAX_M, 0.0, 0.02);
    let points = |n: usize| {
        (0..n).map(|k| {
            let (s, c) = trig::sin_cos(0.1 * k as f64);
            Point2::new(0.05 * k as f64 * c, 0.05 * k as f64 * s)
        })
    };
    // Inside, beyond every side, and nowhere.
    let poses = [
        SE2::new(6.0, 4.5, 0.7),
        SE2::new(-3.0, 4.5, 2.0),
        SE2::new(13.0, 40.0, -2.0),
        SE2::new(1e9, -1e9, 0.0),
        SE2::new(f64::NAN, 1.0, f64::INFINITY),
    ];
    for (pose, n) in poses.into_iter().zip([180, 17, 16, 1, 5]) {
        let mut ends = Ends::default();
        ends.set(points(n));
        let found = field.log_likelihood(&ends, &pose);
        let mut one = Ends::default();
        let alone = points(n).map(|point| {
            one.set(std::iter::once(point));
            field.log_likelihood(&one, &pose)
        });
        let sum: f64 = alone.sum();
        assert!((found - sum).abs() < 1e-9 && found.is_finite(), "{pose:?}: {found}, {sum}");
    }
    let mut none = Ends::default();
    none.set(std::iter::empty());
    assert_eq!(field.log_likelihood(&none, &SE2::identity()), 0.0);
}

#[test]
fn an_end_within_two_deviations_is_on_the_wall() {
    let field = LikelihoodField::of_world(&one_wall(), &model(), RANGE_MAX_M, 0.0, 0.01);
    let mut ends = Ends::default();
    // On either side of the wall at x = 1 m, seen from a body that is turned round.
    let xs_m = [-1.9, -2.1, 0.0, 1.9, 2.1].map(|deviations| 1.0 + deviations * field.sigma_m());
    ends.set(xs_m.iter().map(|x_m| Point2::new(2.0 - x_m, 0.0)));
    let pose = SE2::new(2.0, 1.0, PI);
    assert_eq!(field.on_walls(&ends, &pose), 3);
    ends.set(std::iter::empty());
    assert_eq!(field.on_walls(&ends, &pose), 0);
}

#[test]
fn a_beam_that_comes_to_no_wall_is_in_front_of_it() {
    let field = LikelihoodField::of_world(&one_wall(), &model(), RANGE_MAX_M, 0.0, 0.01);
    let from = Point2::new(-1.0, 1.0);
    for (deviations, is_in_front) in
        [(-50.0, true), (-4.0, true), (-1.9, false), (0.0, false), (4.0, false), (90.0, false)]
    {
        let to = Point2::new(1.0 + deviations * field.sigma_m(), 1.1);
        assert_eq!(field.is_in_front(&from, &to), is_in_front, "{deviations}");
    }
    // Along the wall, and beyond the map.
    assert!(field.is_in_front(&from, &Point2::new(-1.0, -9.0)));
    assert!(field.is_in_front(&from, &Point2::new(-900.0, 1.0)));
}

#[test]
fn what_nobody_has_seen_is_as_likely_as_anything() {
    let origin_m = Point2::new(0.0, 0.0);
    let frame = GridFrame { origin_m, cell_m: 0.05, width: 40, height: 40 };
    let mut map = OccupancyMap::unknown(frame);
    for cell in 0..800 {
        map.cells[cell] = Cell::Free;
    }
    map.cells[20] = Cell::Occupied;
    let distances = DistanceField::of_map(&map);
    let field = LikelihoodField::of_map(&map, &distances, &model(), RANGE_MAX_M, 0.0);
    let at = |x_m: f64, y_m: f64| {
        let mut ends = Ends::default();
        ends.set(std::iter::once(Point2::new(x_m, y_m)));
        field.log_likelihood(&ends, &SE2::identity())
    };
    let half_a_step = 0.5 * field.step_log + 1e-4;
    for (x_m, y_m) in [(1.0, 1.5), (-5.0, 0.0), (0.5, 7.0)] {
        assert!((at(x_m, y_m) + trig::ln(RANGE_MAX_M)).abs() <= half_a_step, "{x_m}, {y_m}");
    }
    assert!((at(1.025, 0.025) - by_the_book(0.0, field.sigma_m())).abs() <= half_a_step);
    assert!((at(1.125, 0.025) - by_the_book(0.1, field.sigma_m())).abs() <= half_a_step);
    // What lies there is in front of no wall.
    let from = Point2::new(0.5, 0.5);
    assert!(field.is_in_front(&from, &Point2::new(0.5, 0.8)));
    assert!(!field.is_in_front(&from, &Point2::new(0.5, 1.5)));
    // Behind a wall as in front of it.
    map.cells[20] = Cell::Free;
    map.cells[790] = Cell::Occupied;
    let distances = DistanceField::of_map(&map);
    let field = LikelihoodField::of_map(&map, &distances, &model(), RANGE_MAX_M, 0.0);
    let at = |y_m: f64| {
        let mut ends = Ends::default();
        ends.set(std::iter::once(Point2::new(1.525, y_m)));
        field.log_likelihood(&ends, &SE2::identity())
    };
    for (distance_m, front_m, behind_m) in [(0.05, 0.925, 1.025), (0.1, 0.875, 1.075)] {
        let wanted = by_the_book(distance_m, field.sigma_m());
        assert!((at(front_m) - wanted).abs() <= half_a_step, "{distance_m}: {}", at(front_m));
        assert!((at(behind_m) - wanted).abs() <= half_a_step, "{distance_m}: {}", at(behind_m));
    }
}

#[test]
fn the_right_pose_has_what_is_expected_of_it() {
    use crate::Random;
    let field = LikelihoodField::of_world(&one_wall(), &model(), RANGE_MAX_M, 0.0, 0.005);
    let (mut random, mut ends) = (Random::new(3, 1), Ends::default());
    let (count, said) = (20_000, field.expected_log());
    ends.set((0..count).map(|_| {
        let strange = random.uniform() < 0.08 / 0.98;
        let x_m = if strange { -1.0 } else { 1.0 + 0.05 * random.normal() };
        Point2::new(x_m, 1.0)
    }));
    let found = field.log_likelihood(&ends, &SE2::identity()) / f64::from(count);
    assert!((found - said).abs() < 0.05, "{found} for {said}");
}

#[test]
fn a_large_world_has_coarse_cells_and_is_as_likely_as_is_expected() {
    use crate::Random;
    let walls = [[0.0, 0.0, 100.0, 0.0], [33.33, 0.0, 33.33, 100.0]];
    let world = world_of([0.0, 0.0, 100.0, 100.0], &walls);
    let model = BeamModel { sigma_hit_m: 0.02, ..model() };
    let field = LikelihoodField::of_world(&world, &model, RANGE_MAX_M, 0.0, 0.01);
    let cell_m = field.frame.cell_m;
    assert!(cell_m > 0.04 && field.frame.cells() <= MOST_CELLS, "{cell_m}");
    assert!((field.sigma_m() - joint(&[0.02, cell_m])).abs() < 1e-12, "{}", field.sigma_m());
    let (mut random, mut ends) = (Random::new(3, 1), Ends::default());
    let count = 20_000;
    ends.set((0..count).map(|k| {
        let strange = random.uniform() < 0.08 / 0.98;
        let off_m = if strange { 3.0 } else { 0.02 * random.normal() };
        Point2::new(33.33 + off_m, 2.0 + 0.004 * f64::from(k))
    }));
    let found = field.log_likelihood(&ends, &SE2::identity()) / f64::from(count);
    // No worse than a robot at the right pose has to be; better, as its laser is
    // not as blurred as the cells are.
    let ratio = trig::exp(found - field.expected_log());
    assert!((0.98..1.8).contains(&ratio), "{ratio}");
}
