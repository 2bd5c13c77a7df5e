//! A peak on an empty grid: its motion, its spread, and the sum of the masses.

use super::*;
use nalgebra::Point2;

const FREE: GridFrame =
    GridFrame { origin_m: Point2::new(-2.0, -1.5), cell_m: 0.1, width: 40, height: 30 };

fn cells() -> Cells {
    Cells::new(FREE, vec![true; FREE.cells()], 72)
}

/// Sum, mean and covariance of the poses of all cells.
fn moments(cells: &Cells, near: &SE2) -> (f64, SE2, Matrix3<f64>) {
    let width = cells.frame.width;
    let layers = cells.layers.iter().enumerate();
    let all: Vec<(SE2, f64)> = layers
        .flat_map(|(j, l)| l.occupied(width).map(move |(cell, mass)| (cells.pose(j, cell), mass)))
        .collect();
    let sum: f64 = all.iter().map(|(_, mass)| mass).sum();
    let to_world = |pose: &SE2| {
        let way = pose.translation() - near.translation();
        Vector3::new(way.x, way.y, wrap_angle(pose.theta() - near.theta()))
    };
    let mean = all.iter().fold(Vector3::zeros(), |s, (pose, mass)| s + to_world(pose) * *mass);
    let mut covariance = Matrix3::zeros();
    for (pose, mass) in &all {
        let off = to_world(pose) - mean;
        covariance += off * off.transpose() * *mass;
    }
    (sum, SE2::new(near.x() + mean.x, near.y() + mean.y, near.theta() + mean.z), covariance)
}

fn distance(a: &SE2, b: &SE2) -> f64 {
    (a.translation() - b.translation()).norm().max(wrap_angle(a.theta() - b.theta()).abs())
}

#[test]
fn a_peak_moves_by_the_motion_and_spreads_by_its_covariance() {
    for (start, way) in [
        (SE2::new(0.03, 0.04, 0.7), SE2::new(0.31, 0.02, 0.4)),
        (SE2::new(-0.5, 0.2, 3.1), SE2::new(-0.12, 0.0, 0.2)),
    ] {
        let end = start.compose(&way);
        let body = Matrix3::from_diagonal(&Vector3::new(2e-3, 5e-4, 0.0));
        let mut cells = cells();
        cells.fill_around(&start, 1e-3, 1e-3);
        cells.move_by(&Motion { now_in_then: way, covariance: body }, 0.0);
        let (sum, mean, covariance) = moments(&cells, &end);
        assert!((sum - 1.0).abs() < 1e-12 && distance(&mean, &end) < 1e-12, "{sum}, {mean:?}");
        let (s, c) = trig::sin_cos(end.theta());
        let expected = [c * c * 2e-3 + s * s * 5e-4, s * s * 2e-3 + c * c * 5e-4, 0.0];
        for (k, expected) in expected.into_iter().enumerate() {
            assert!((covariance[(k, k)] - expected).abs() < 1e-12, "{k}: {covariance}");
        }
    }
}

#[test]
fn an_error_of_the_heading_spreads_the_headings_and_bends_the_way() {
    let (start, sigma2) = (SE2::new(-1.0, 0.0, 0.0), 4e-3);
    let mut cells = cells();
    cells.fill_around(&start, 1e-3, 1e-3);
    let turn = Motion {
        now_in_then: SE2::identity(),
        covariance: Matrix3::from_diagonal(&Vector3::new(0.0, 0.0, sigma2)),
    };
    cells.move_by(&turn, 0.0);
    let straight = Motion { now_in_then: SE2::new(1.5, 0.0, 0.0), ..Motion::default() };
    cells.move_by(&straight, 0.0);
    let (sum, _, covariance) = moments(&cells, &start);
    assert!((sum - 1.0).abs() < 1e-12 && (covariance[(2, 2)] - sigma2).abs() < 1e-12);
    // y = 1.5 m · sin θ, and three headings of 5° are nearly their sines.
    assert!((covariance[(1, 1)] / (2.25 * sigma2) - 1.0).abs() < 0.01, "{covariance}");
    assert!((covariance[(1, 2)] / (1.5 * sigma2) - 1.0).abs() < 0.01, "{covariance}");
}

#[test]
fn the_sum_stays_1_and_all_zero_becomes_uniform() {
    let mut cells = cells();
    cells.mix(1.0);
    let noise = Matrix3::from_diagonal(&Vector3::new(1e-3, 1e-3, 1e-2));
    for k in 0..20 {
        let now_in_then = SE2::new(0.07, 0.01, 0.3);
        cells.move_by(&Motion { now_in_then, covariance: noise }, 0.1);
        if k % 5 == 0 {
            cells.mix(0.01);
        }
        cells.normalise();
        let (sum, ..) = moments(&cells, &SE2::identity());
        assert!((sum - 1.0).abs() < 1e-9, "{k}: {sum}");
    }
    // Beyond the grid, and with an error that has no number.
    for way_m in [1e3, 1e300] {
        let far = Motion { now_in_then: SE2::new(way_m, 0.0, 0.0), covariance: noise * f64::MAX };
        cells.move_by(&far, 0.1);
        cells.normalise();
        let occupied: usize = cells.layers.iter().map(|l| l.occupied(FREE.width).count()).sum();
        assert_eq!(occupied, cells.free_count());
        cells = self::cells();
    }
}
