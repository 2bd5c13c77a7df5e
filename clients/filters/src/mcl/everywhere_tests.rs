//! Tests of the search for all places.

use super::*;
use crate::occupancy::Cell;
use crate::{BeamModel, Beams, DistanceField, OccupancyMap};
use rusty_contract::config::LidarConfig;
use rusty_geometry::{Material, Scan, World};

const SENSOR: Point2<f64> = Point2::new(0.0, 0.0);

/// The Apartment in a field of σ = 0.12 m, and the ends of a scan there.
fn look(truth: &SE2) -> (World, Everywhere, Vec<Point2<f64>>) {
    let (world, lidar) = (rusty_geometry::apartment(), LidarConfig::default());
    let (model, beams) = (BeamModel::of_lidar(&lidar), Beams::new(&lidar));
    let field = LikelihoodField::of_world(&world, &model, beams.range_max_m, 0.12, 0.06);
    let everywhere = Everywhere::new(&field, &FreeSpace::of_world(&world, 0.11));
    let mut scan = Scan::new(lidar.fan());
    scan.take(&world, truth, beams.range_max_m);
    let mut ranges_m = vec![0.0; beams.count()];
    scan.write_distances_m(&mut ranges_m);
    let ends = beams.endpoints(&ranges_m).step_by(3).map(|end| end.in_body).collect();
    (world, everywhere, ends)
}

/// The scores of the ends with a wall in the way.
fn hidden_scores(everywhere: &Everywhere, ends: &[Point2<f64>], pose: &SE2) -> Vec<u32> {
    let from = pose.transform_point(&SENSOR);
    let points = ends.iter().map(|end| pose.transform_point(end));
    let hidden = points.filter(|&to| everywhere.is_hidden(from, to));
    hidden.map(|to| u32::from(everywhere.score_at(everywhere.frame.column_row(to)))).collect()
}

#[test]
fn the_best_fit_is_that_of_all_poses_and_the_others_fit_worse() {
    for truth in [SE2::new(9.6, 3.0, 0.4), SE2::new(1.6, 6.6, -1.2), SE2::new(6.0, 4.5, 3.0)] {
        let (_, everywhere, ends) = look(&truth);
        let fits = everywhere.best(&SENSOR, &ends, 20, 0.8);
        let GridFrame { width, height, .. } = everywhere.frame;
        let is_near = |pose: &SE2, fit: &Fit| {
            let off = fit.pose_in_world.inverse().compose(pose);
            off.translation().norm() < APART_M + 1e-9 && off.theta().abs() < APART_RAD + 1e-9
        };
        let (mut best, mut other) = (0, 0);
        for turn in 0..TURNS {
            let cells = everywhere.cells(&ends, turn);
            let at = (0..width as i32).flat_map(|x| (0..height as i32).map(move |y| [x, y]));
            for at in at.filter(|at| everywhere.free.most(0, at[0], at[1]) > 0) {
                let (sum, pose) = (everywhere.scores.sum(0, &cells, at), everywhere.pose(turn, at));
                best = best.max(sum);
                if sum > other && !fits.places.iter().any(|fit| is_near(&pose, fit)) {
                    other = sum;
                }
            }
        }
        let log = |sum: u32| everywhere.mean_log(sum, ends.len());
        let pose = fits.places[0].pose_in_world;
        let hidden = hidden_scores(&everywhere, &ends, &pose);
        assert_eq!(fits.places[0].mean_log, log(best - hidden.iter().sum::<u32>()), "{truth:?}");
        // At the right place at most one of them, past two corners.
        assert!(hidden.len() <= 1, "{truth:?}: {hidden:?} of {}", ends.len());
        assert!(log(other) <= fits.others_log, "{} {fits:?}", log(other));
        assert!(fits.others_log <= fits.places.last().unwrap().mean_log, "{fits:?}");
        let off = truth.inverse().compose(&fits.places[0].pose_in_world);
        assert!(off.translation().norm() < 0.1 && off.theta().abs() < 0.05, "{off:?}");
    }
}

#[test]
fn places_are_apart_and_free_and_their_number_is_limited() {
    let (world, everywhere, ends) = look(&SE2::new(9.6, 3.0, 0.4));
    let fits = everywhere.best(&SENSOR, &ends, 12, 3.0);
    assert_eq!(fits.places.len(), 12);
    for (k, fit) in fits.places.iter().enumerate() {
        let at = Point2::from(fit.pose_in_world.translation());
        assert!(world.distance_to_nearest(at) > 0.11 - 0.08, "{fit:?}");
        for other in &fits.places[..k] {
            let off = other.pose_in_world.inverse().compose(&fit.pose_in_world);
            let is_apart = off.translation().norm() > APART_M || off.theta().abs() > APART_RAD;
            assert!(is_apart && other.mean_log >= fit.mean_log, "{fit:?} {other:?}");
        }
    }
    assert!(everywhere.best(&SENSOR, &[], 12, 3.0).places.len() == 12, "nothing fits everywhere");
}

#[test]
fn a_wall_counts_only_where_none_is_in_front_of_it() {
    let (_, everywhere, _) = look(&SE2::new(9.6, 3.0, 0.4));
    let log_in = |everywhere: &Everywhere, from: [f64; 2], to: [f64; 2]| {
        let (pose, end) = (SE2::new(from[0], from[1], 0.0), Point2::from(to));
        everywhere.fit(&SENSOR, &[end - Vector2::from(from)], pose).mean_log
    };
    let log = |from, to| log_in(&everywhere, from, to);
    let [wall, random] = [255, 0].map(|score| everywhere.mean_log(score, 1));
    let is = |found: f64, wanted: f64| (found - wanted).abs() < 0.1;
    // The wall of x = 7.2 m (from y = 5 to 9 m) from its left, and the outer one behind it.
    assert!(is(log([6.0, 7.5], [7.2, 7.5]), wall));
    assert!(is(log([6.0, 7.5], [12.0, 7.5]), random));
    assert!(is(log([8.0, 7.5], [12.0, 7.5]), wall));
    // Past its end at y = 5 m, and 0.05 m on the wrong side of it.
    assert!(is(log([6.0, 4.8], [12.0, 4.8]), wall));
    assert!(is(log([6.0, 5.05], [12.0, 5.05]), wall));
    assert!(is(log([6.0, 5.5], [12.0, 5.5]), random));
    // A beam along it, nearly on it.
    assert!(is(log([7.22, 5.3], [7.2, 9.0]), wall));
    // Beams pass it if it is of glass, but not the wall of y = 6 m from x = 9.8 to 12 m.
    let [a, b] = [[7.2, 5.0], [7.2, 9.0]].map(Point2::from);
    let panes = [Wall { a, b, material: Material::Glass }];
    let glass = everywhere.clone().with_glass(&panes);
    assert!(is(log_in(&glass, [6.0, 7.5], [12.0, 7.5]), wall));
    assert!(is(log_in(&glass, [11.0, 5.0], [11.0, 9.0]), random));
}

/// A free room of 3 m × 3 m on a map of 6 m × 6 m; nothing was seen beyond its walls.
fn room() -> OccupancyMap {
    let frame =
        GridFrame { origin_m: Point2::new(0.0, 0.0), cell_m: 0.05, width: 120, height: 120 };
    let mut map = OccupancyMap::unknown(frame);
    for (column, row) in (30..90).flat_map(|column| (30..90).map(move |row| (column, row))) {
        let is_wall = [column, row].iter().any(|at| [30, 89].contains(at));
        let cell = frame.index(column, row).unwrap();
        map.cells[cell] = if is_wall { Cell::Occupied } else { Cell::Free };
    }
    map
}

#[test]
fn an_end_that_was_not_seen_is_likely_unless_a_wall_hides_it() {
    let map = room();
    let distances = DistanceField::of_map(&map);
    let model = BeamModel::of_lidar(&LidarConfig::default());
    let field = LikelihoodField::of_map(&map, &distances, &model, 8.0, 0.1);
    let everywhere = Everywhere::new(&field, &FreeSpace::of_map(&map, &distances, 0.11));
    let log = |from: [f64; 2], to: [f64; 2]| {
        let [here, end] = [from, to].map(Point2::from);
        let pose = SE2::new(here.x, here.y, 0.0);
        everywhere.fit(&SENSOR, &[end - here.coords], pose).mean_log
    };
    let (random, unseen) = (field.log_at_distance(100.0), -trig::ln(8.0));
    let is = |found: f64, wanted: f64| (found - wanted).abs() < 0.05;
    // Out of the room, from inside and from outside; and on its wall, from both sides.
    assert!(is(log([3.0, 3.0], [3.0, 5.5]), random), "{}", log([3.0, 3.0], [3.0, 5.5]));
    assert!(is(log([0.5, 5.5], [3.0, 5.5]), unseen), "{}", log([0.5, 5.5], [3.0, 5.5]));
    assert!(is(log([-9.0, 50.0], [-5.0, 50.0]), unseen));
    let wall = field.log_at_distance(0.0);
    assert!(is(log([3.0, 3.0], [3.0, 4.475]), wall) && is(log([3.0, 5.5], [3.0, 4.475]), wall));
    // A wall that is nearer to the end than 0.3 m is the one that was met.
    assert!(is(log([3.0, 3.0], [3.0, 4.72]), field.log_at_distance(0.25).max(unseen)));
    // Of one place there is one fit, the better ones first.
    let mut fits = Fits { places: Vec::new(), others_log: random };
    for (x_m, mean_log) in [(1.0, -1.0), (1.3, -0.5), (3.0, -0.7), (5.0, -2.0)] {
        fits.add(Fit { pose_in_world: SE2::new(x_m, 0.0, 0.0), mean_log });
    }
    let found: Vec<f64> = fits.places.iter().map(|fit| fit.mean_log).collect();
    assert_eq!(found, [-0.7, -1.0, -2.0]);
}
