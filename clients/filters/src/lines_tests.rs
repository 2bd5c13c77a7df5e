//! Line extraction on scans of known rooms, beam by beam.

use super::*;
use crate::Random;
use crate::scan_match::tests::world_of;
use nalgebra::Vector2;
use rusty_contract::LidarConfig;
use rusty_geometry::{Scan, World, trig};

const EXTRACTION: Extraction = Extraction { range_std_m: 0.02, min_points: 6, min_length_m: 0.4 };

/// A room of 4 m by 3 m.
fn room() -> World {
    let (right, back) = ([0.0, 0.0, 4.0, 0.0], [4.0, 0.0, 4.0, 3.0]);
    let (left, front) = ([4.0, 3.0, 0.0, 3.0], [0.0, 3.0, 0.0, 0.0]);
    world_of([0.0, 0.0, 4.0, 3.0], &[right, back, left, front])
}

/// Exact ranges from a body pose, and the wall that each beam met.
fn look(lidar: &LidarConfig, world: &World, pose: &SE2) -> (Vec<f64>, Vec<Option<usize>>) {
    let mut scan = Scan::new(lidar.fan());
    scan.take(world, &pose.compose(&lidar.sensor_in_body), lidar.range_max_m);
    scan.distances_and_walls().unzip()
}

/// α and ρ of the four walls of the room, seen from a pose.
fn walls_from(pose: &SE2) -> [(f64, f64); 4] {
    let quarter = std::f64::consts::FRAC_PI_2;
    let world = [(-quarter, 0.0), (0.0, 4.0), (quarter, 3.0), (2.0 * quarter, 0.0)];
    world.map(|(alpha_rad, rho_m)| {
        let (s, c) = trig::sin_cos(alpha_rad);
        let rho_m = rho_m - (c * pose.x() + s * pose.y());
        (rusty_geometry::wrap_angle(alpha_rad - pose.theta()), rho_m)
    })
}

fn has(segments: &[Segment], (alpha_rad, rho_m): (f64, f64), tolerance: f64) -> Segment {
    let fits = |s: &&Segment| {
        let turn = rusty_geometry::wrap_angle(s.line.alpha_rad - alpha_rad).abs();
        turn < tolerance && (s.line.rho_m - rho_m).abs() < tolerance
    };
    let found: Vec<_> = segments.iter().filter(fits).collect();
    assert_eq!(found.len(), 1, "α {alpha_rad}, ρ {rho_m} in {segments:?}");
    *found[0]
}

#[test]
fn every_beam_of_a_room_is_with_its_wall() {
    let (world, pose) = (room(), SE2::new(1.2, 1.3, 0.4));
    let lidar = LidarConfig { sensor_in_body: SE2::new(0.1, 0.05, 0.3), ..Default::default() };
    let beams = Beams::new(&lidar);
    let (ranges_m, met) = look(&lidar, &world, &pose);
    let sensor = pose.compose(&lidar.sensor_in_body);
    let segments = EXTRACTION.segments(&beams, &ranges_m);
    assert_eq!(segments.len(), 4, "{segments:?}");
    let mut points = [0; 4];
    for (k, wall) in met.iter().enumerate() {
        // Near a corner the next wall's line is at nearly the same range.
        let direction =
            SE2::new(0.0, 0.0, sensor.theta()).transform_point(&Point2::from(beams.direction(k)));
        let to = |bound: f64, from: f64, along: f64| (bound - from) / along;
        let lines = [
            to(0.0, sensor.y(), direction.y),
            to(4.0, sensor.x(), direction.x),
            to(3.0, sensor.y(), direction.y),
            to(0.0, sensor.x(), direction.x),
        ];
        let nobodys = |line: &f64| (line - ranges_m[k]).abs() < 7.0 * 0.02;
        points[wall.unwrap()] += usize::from(lines.iter().filter(|l| nobodys(l)).count() == 1);
    }
    points.iter_mut().for_each(|points| *points -= 2 * END_POINTS);
    // In the body frame, where the laser is not: the poses differ.
    for (wall, expected) in walls_from(&pose).into_iter().enumerate() {
        let found = has(&segments, expected, 1e-9);
        assert_eq!(found.points, points[wall], "wall {wall}");
        let across = |p: &Point2<f64>| found.line.normal().dot(&p.coords) - expected.1;
        assert!(across(&found.from).abs() < 1e-9 && across(&found.to).abs() < 1e-9);
    }
}

#[test]
fn noise_and_lost_beams_end_no_wall() {
    let (world, pose) = (room(), SE2::new(1.2, 1.3, 0.4));
    let (lidar, mut random) = (LidarConfig::default(), Random::new(3, 1));
    let (beams, mut whole) = (Beams::new(&lidar), 0);
    for _ in 0..200 {
        let (mut ranges_m, _) = look(&lidar, &world, &pose);
        for range_m in &mut ranges_m {
            *range_m += 0.02 * random.normal();
            if random.uniform() < 0.05 {
                *range_m = lidar.range_max_m;
            }
        }
        let segments = EXTRACTION.segments(&beams, &ranges_m);
        whole += usize::from(segments.len() == 4);
        for wall in walls_from(&pose) {
            let is_its = |s: &&Segment| (s.line.alpha_rad - wall.0).abs() < 0.2;
            assert!(segments.iter().any(|s| is_its(&s)), "{wall:?} in {segments:?}");
            for Segment { line, .. } in segments.iter().filter(is_its) {
                let error = Vector2::new(line.alpha_rad - wall.0, line.rho_m - wall.1);
                let nees = error.dot(&(line.covariance.try_inverse().unwrap() * error));
                assert!(nees < 25.0, "{nees} of {line:?}");
            }
        }
    }
    // A range more than four σ off comes once in 16 000, and parts its wall.
    assert!(whole >= 194, "{whole} of 200 scans have four walls");
}

#[test]
fn a_door_is_between_two_walls_and_not_in_one() {
    // In the Apartment's corridor: the wall on the right has doorways.
    let (lidar, pose) = (LidarConfig::default(), SE2::new(3.4, 4.5, 0.0));
    let beams = Beams::new(&lidar);
    let (ranges_m, _) = look(&lidar, &rusty_geometry::apartment(), &pose);
    let segments = EXTRACTION.segments(&beams, &ranges_m);
    let right: Vec<_> = segments
        .iter()
        .filter(|s| (s.line.rho_m - 0.6).abs() < 1e-9 && s.line.alpha_rad < 0.0)
        .map(|s| [s.from.x + 3.4, s.to.x + 3.4])
        .collect();
    assert!(right.iter().any(|[a, b]| *a > 1.9 && *b < 4.4 && b - a > 2.0), "{right:?}");
    for [a, b] in right {
        let inside = [[0.0, 0.9], [1.9, 4.4], [5.4, 7.2]];
        assert!(inside.iter().any(|w| w[0] - 1e-9 <= a && b <= w[1] + 1e-9), "{a} to {b}");
    }
    // The end of the corridor, between the walls of the corridor and no farther.
    let is_end = |s: &&Segment| {
        (s.from.x + 3.4).abs() < 1e-9 && s.from.y < 0.6 && s.to.y > -0.6 && s.points >= 6
    };
    assert_eq!(segments.iter().filter(is_end).count(), 1, "{segments:?}");
}

#[test]
fn nothing_and_nonsense_have_no_walls() {
    let lidar = LidarConfig { beams: 12, ..LidarConfig::default() };
    let beams = Beams::new(&lidar);
    for ranges_m in [vec![], vec![8.0; 12], vec![f64::NAN; 12], vec![0.0; 12], vec![1.0; 3]] {
        assert_eq!(EXTRACTION.segments(&beams, &ranges_m), []);
    }
    let one = Beams::new(&LidarConfig { beams: 1, ..lidar });
    assert_eq!(EXTRACTION.segments(&one, &[2.0]), []);
}
