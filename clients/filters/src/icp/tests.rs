//! Matching in the Apartment, in a corridor, and of scans that are none.

use nalgebra::{Matrix3, Point2, Vector3};
use rusty_contract::config::LidarConfig;
use rusty_geometry::{SE2, Scan, World, apartment};

use super::*;
use crate::Random;
use crate::scan_match::tests::world_of;

/// Where the Apartment shows walls in both directions.
const ROOMS: [[f64; 3]; 6] = [
    [1.3, 2.5, 0.3],
    [5.0, 2.6, -2.0],
    [9.5, 3.0, 1.2],
    [10.0, 7.5, 3.0],
    [5.2, 7.0, -0.7],
    [1.6, 7.0, 2.2],
];

/// A laser in a world.
struct Eye {
    world: World,
    lidar: LidarConfig,
    laser: Laser,
    random: Random,
}

impl Eye {
    fn new(world: World, beams: u32, range_std_m: f64, seed: u64) -> Self {
        let lidar = LidarConfig { beams, range_std_m, ..LidarConfig::default() };
        Self { world, laser: Laser::new(&lidar), lidar, random: Random::new(seed, 1) }
    }

    fn rays(&mut self, pose: &SE2) -> Vec<Ray> {
        let mut scan = Scan::new(self.lidar.fan());
        scan.take(&self.world, pose, self.lidar.range_max_m);
        let (max_m, std_m) = (self.lidar.range_max_m, self.lidar.range_std_m);
        let noisy = |(range_m, wall): (f64, Option<usize>)| {
            wall.map_or(max_m, |_| range_m + std_m * self.random.normal())
        };
        let ranges_m: Vec<f64> = scan.distances_and_walls().map(noisy).collect();
        self.laser.rays(&ranges_m)
    }

    fn surface(&mut self, pose: &SE2) -> Surface {
        let rays = self.rays(pose);
        Surface::new(&self.laser, &rays, IcpOptions::default().roughness_m)
    }

    /// The scan from `then` compared with the scan from `then ∘ moved`, begun at `guess`.
    fn matched(&mut self, then: &SE2, moved: &SE2, guess: &SE2) -> Result<Match, NoMatch> {
        let options = IcpOptions::default();
        let surface = self.surface(then);
        let scan = self.surface(&(*then * *moved));
        match_scans(&surface, &self.laser, &scan, guess, &loose(guess), &options)
    }
}

/// A belief that says nothing.
fn loose(guess: &SE2) -> Motion {
    Motion { now_in_then: *guess, covariance: Matrix3::identity() * 1e4 }
}

fn pose([x, y, theta]: [f64; 3]) -> SE2 {
    SE2::new(x, y, theta)
}

#[test]
fn without_noise_the_motion_is_found() {
    let mut eye = Eye::new(apartment(), 360, 1e-4, 1);
    eye.lidar.range_std_m = 0.0;
    for room in ROOMS {
        for moved in [[0.0, 0.0, 0.0], [0.3, 0.1, 0.2], [-0.2, 0.25, -0.3]] {
            let found = eye.matched(&pose(room), &pose(moved), &SE2::identity()).unwrap();
            let error = found.evidence.constraint().unwrap().0.boxminus(&pose(moved));
            assert!(error.norm() < 1e-3, "{room:?} {moved:?}: {error} of {found:?}");
        }
    }
}

#[test]
fn the_basin_is_what_the_module_says() {
    // 0.4 m and 20° off in every direction, with noise, 180 beams.
    let mut eye = Eye::new(apartment(), 180, 0.02, 2);
    let (mut found, mut all) = (0, 0);
    for room in ROOMS {
        for k in 0..16 {
            let (s, c) = rusty_geometry::trig::sin_cos(std::f64::consts::FRAC_PI_8 * f64::from(k));
            let turn_rad = if k % 2 == 0 { 0.349 } else { -0.349 };
            let moved = SE2::new(0.1, 0.05, 0.1);
            let guess = SE2::new(0.1 + 0.4 * c, 0.05 + 0.4 * s, 0.1 + turn_rad);
            let came = eye.matched(&pose(room), &moved, &guess);
            let close = |m: Match| m.evidence.at.boxminus(&moved).norm() < 0.05;
            found += u32::from(came.is_ok_and(close));
            all += 1;
        }
    }
    assert!(f64::from(found) >= 0.95 * f64::from(all), "{found} of {all}");
}

#[test]
fn the_covariance_is_that_of_noise_that_is_drawn() {
    let mut eye = Eye::new(apartment(), 180, 0.02, 3);
    for room in &ROOMS[1..4] {
        let moved = SE2::new(0.15, 0.05, 0.1);
        let (mut drawn, mut said, count) = (Matrix3::zeros(), Matrix3::zeros(), 300);
        for _ in 0..count {
            let found = eye.matched(&pose(*room), &moved, &moved).unwrap();
            let (z, information) = found.evidence.constraint().unwrap();
            let error = moved.boxminus(&z);
            drawn += error * error.transpose() / f64::from(count);
            said += information.try_inverse().unwrap() / f64::from(count);
        }
        for k in 0..3 {
            let ratio = said[(k, k)] / drawn[(k, k)];
            assert!((0.5..2.0).contains(&ratio), "{room:?}, {k}: {ratio}, {said} for {drawn}");
        }
    }
}

/// Two parallel walls, 40 m long.
fn corridor() -> World {
    let walls = [[-20.0, -0.6, 20.0, -0.6], [-20.0, 0.6, 20.0, 0.6]];
    world_of([-20.0, -1.0, 20.0, 1.0], &walls)
}

#[test]
fn a_corridor_says_nothing_along_itself() {
    let mut eye = Eye::new(corridor(), 180, 0.02, 4);
    let options = IcpOptions::default();
    let moved = SE2::new(0.5, 0.02, 0.03);
    // What wheels say: 1 cm of 50 along, and little about the rest.
    let wheels = Motion {
        now_in_then: SE2::new(0.51, 0.0, 0.0),
        covariance: Matrix3::from_diagonal(&Vector3::new(1e-4, 1e-2, 1e-2)),
    };
    for _ in 0..20 {
        let surface = eye.surface(&SE2::identity());
        let scan = eye.surface(&moved);
        let guess = wheels.now_in_then;
        let found = match_scans(&surface, &eye.laser, &scan, &guess, &wheels, &options).unwrap();
        let fused = found.evidence.fuse(&wheels).unwrap().motion;
        let deviation = |k: usize| fused.covariance[(k, k)].sqrt();
        // Along it stays the wheels' business; across and round it is measured.
        assert!(deviation(0) > 0.009, "{fused:?}");
        assert!(deviation(1) < 0.01 && deviation(2) < 0.01, "{fused:?}");
        assert!((fused.now_in_then.x() - 0.51).abs() < 0.006, "{fused:?}");
        assert!((fused.now_in_then.y() - 0.02).abs() < 0.02, "{fused:?}");
        assert!((fused.now_in_then.theta() - 0.03).abs() < 0.02, "{fused:?}");
    }
}

/// A corridor of 40 m with a niche of half a metre on each side, every 5 m.
fn niches() -> World {
    let mut walls = Vec::new();
    for (y_m, deep_m) in [(-1.2, -1.7), (1.3, 1.8)] {
        for k in 0..8 {
            let (x_m, from_m) = (5.0 * f64::from(k) - 20.0, 5.0 * f64::from(k) - 18.0);
            let to_m = from_m + 1.0;
            walls.extend([
                [x_m, y_m, from_m, y_m],
                [from_m, y_m, from_m, deep_m],
                [from_m, deep_m, to_m, deep_m],
                [to_m, deep_m, to_m, y_m],
                [to_m, y_m, x_m + 5.0, y_m],
            ]);
        }
    }
    world_of([-20.0, -2.0, 20.0, 2.0], &walls)
}

#[test]
fn after_wheels_that_turned_and_slid_a_little_scans_match_at_the_truth() {
    let mut eye = Eye::new(niches(), 180, 0.01, 6);
    let half_rad = std::f64::consts::FRAC_PI_2;
    eye.lidar.range_max_m = 30.0;
    (eye.lidar.fov_rad, eye.lidar.first_bearing_rad) = (2.0 * half_rad, -half_rad);
    eye.laser = Laser::new(&eye.lidar);
    let std = Vector3::new(0.1, 0.05, 0.08);
    let (options, mut random) = (IcpOptions::default(), Random::new(7, 1));
    let (mut sum, mut false_minima, count) = (0.0, 0, 200);
    for k in 0..count {
        let then = SE2::new(-8.0 + 0.04 * f64::from(k), 0.1, 0.05);
        let moved = SE2::new(0.9, 0.02, 0.02);
        let off = Vector3::from_fn(|i, _| std[i] * random.normal());
        let wheels = Motion {
            now_in_then: moved.boxplus(&off),
            covariance: Matrix3::from_diagonal(&std.component_mul(&std)),
        };
        let mut seen = |pose: &SE2| {
            let mut rays = eye.rays(pose);
            // Some beams end in the air before their walls.
            for ray in &mut rays {
                if random.normal() > 2.0 {
                    let part = 1.0 / (1.0 + random.normal().abs());
                    ray.point = Point2::from(ray.point.coords * part);
                }
            }
            Surface::new(&eye.laser, &rays, options.roughness_m)
        };
        let (surface, scan) = (seen(&then), seen(&(then * moved)));
        let guess = wheels.now_in_then;
        let found = match_scans(&surface, &eye.laser, &scan, &guess, &wheels, &options).unwrap();
        let fused = found.evidence.fuse(&wheels).unwrap().motion;
        let error = moved.boxminus(&fused.now_in_then);
        let nees = (error.transpose() * fused.covariance.try_inverse().unwrap() * error).x;
        if nees < 30.0 { sum += nees } else { false_minima += 1 }
    }
    // Of 3000 draws 8 or 9 end in a false minimum.
    assert!(false_minima <= 2, "{false_minima}");
    let anees = sum / f64::from(count - false_minima);
    assert!(anees < 3.0, "{anees}");
}

#[test]
fn a_corridor_says_no_more_of_a_longer_way_than_of_a_shorter_one() {
    // What a match of two scans says of the way along two bare walls, at the true pose: nothing
    // on average, however long the way. With y as the derivative of the metric it is 7.3 ± 0.2
    // for 0.6 m.
    let world =
        world_of([-40.0, -2.0, 40.0, 2.0], &[[-40.0, 1.3, 40.0, 1.3], [-40.0, -1.3, 40.0, -1.3]]);
    let mut eye = Eye::new(world, 180, 0.02, 5);
    let half_rad = std::f64::consts::FRAC_PI_2;
    (eye.lidar.fov_rad, eye.lidar.first_bearing_rad) = (2.0 * half_rad, -half_rad);
    eye.laser = Laser::new(&eye.lidar);
    let viewpoint = eye.laser.view().viewpoint;
    for way_m in [0.001, 0.6] {
        let (mut sum, mut squares, count) = (0.0, 0.0, 400);
        for k in 0..count {
            let then = SE2::new(0.0, -0.3 + 0.6 * f64::from(k) / f64::from(count), 0.0);
            let moved = SE2::new(way_m, 0.0, 0.0);
            let (surface, scan) = (eye.surface(&then), eye.surface(&(then * moved)));
            let by = Nearest::ByMiddle;
            let pairs = trimmed(pairs(&surface, &scan, &viewpoint, &moved, 0.15, by));
            let along = Evidence::of(&surface, scan.rays(), &pairs, &moved, true).measured.x;
            (sum, squares) = (sum + along, squares + along * along);
        }
        let (mean, square) = (sum / f64::from(count), squares / f64::from(count));
        let deviation = ((square - mean * mean) / f64::from(count)).sqrt();
        assert!(mean.abs() < 3.0 * deviation, "{way_m} m: {mean} ± {deviation}");
    }
}

#[test]
fn what_is_known_is_counted_from_the_pose_that_it_is_about() {
    // A measurement of 3 m and some turn from where it was linearised; what a pose
    // compared with the one that comes out costs, by the measurement itself.
    let tau = Vector3::new(3.0, 0.1, 0.3);
    let root = Matrix3::new(40.0, 3.0, -8.0, 0.0, 70.0, 20.0, 0.0, 0.0, 90.0);
    let gain = root.transpose() * root;
    let at = SE2::new(-1.0, 2.0, 0.7);
    let evidence = Evidence { at, gain, measured: gain * tau, noise: gain };
    let (z, information) = evidence.constraint().unwrap();
    assert!(z.boxminus(&at.boxplus(&tau)).norm() < 1e-6, "{z:?}");
    for by in
        [Vector3::new(1.0, 0.0, 0.0), Vector3::new(0.0, 1.0, 0.5), Vector3::new(0.2, 0.3, 1.0)]
    {
        let by = by * 1e-4;
        let off = z.boxplus(&by).boxminus(&at) - tau;
        let (costs, said) =
            ((off.transpose() * gain * off).x, (by.transpose() * information * by).x);
        assert!((said / costs - 1.0).abs() < 1e-3, "{by}: {said} for {costs}");
    }
    // With a belief that says nothing that is all that is known.
    let fused = evidence.fuse(&loose(&at)).unwrap().motion;
    assert!(fused.now_in_then.boxminus(&z).norm() < 1e-6, "{fused:?}");
    let product = fused.covariance * information;
    assert!((product - Matrix3::identity()).norm() < 1e-4, "{product}");
}

#[test]
fn scans_that_are_none_are_named() {
    let mut eye = Eye::new(apartment(), 180, 0.02, 5);
    let options = IcpOptions::default();
    let here = pose(ROOMS[1]);
    let surface = eye.surface(&here);
    let prior = loose(&SE2::identity());
    let with = |surface: &Surface, rays: &[Ray], guess: &SE2| {
        let scan = Surface::new(&eye.laser, rays, options.roughness_m);
        match_scans(surface, &eye.laser, &scan, guess, &prior, &options)
    };
    // Nothing met, two points, a NaN everywhere, no reference.
    let mut two = vec![8.0; 180];
    (two[3], two[90]) = (1.0, 2.0);
    for (ranges_m, found) in [(vec![8.0; 180], 0), (two, 2), (vec![f64::NAN; 180], 0), (vec![], 0)]
    {
        let rays = eye.laser.rays(&ranges_m);
        assert_eq!(with(&surface, &rays, &SE2::identity()), Err(NoMatch::FewEnds { found }));
        let nothing = Surface::new(&eye.laser, &rays, options.roughness_m);
        assert_eq!(nothing.pieces().len(), 0);
        let rays = surface.rays();
        assert_eq!(with(&nothing, rays, &SE2::identity()), Err(NoMatch::FewPieces { found: 0 }));
    }
    // Another room, and a useless guess.
    let away = with(&surface, surface.rays(), &SE2::new(30.0, 0.0, 0.0));
    assert!(matches!(away, Err(NoMatch::FewPairs { pairs: 0, .. })), "{away:?}");
    let none = with(&surface, surface.rays(), &SE2::new(f64::NAN, 0.0, 0.0));
    assert!(none.is_err(), "{none:?}");
    let mut other = Eye::new(apartment(), 180, 0.02, 6);
    let elsewhere = other.rays(&pose(ROOMS[3]));
    let words = with(&surface, &elsewhere, &SE2::identity());
    assert!(words.is_err() || words.is_ok_and(|m| m.share < 0.7), "{words:?}");
}

#[test]
fn the_bits_are_pinned() {
    let mut eye = Eye::new(apartment(), 180, 0.02, 8);
    let found = eye.matched(&pose(ROOMS[2]), &pose([0.1, 0.0, 0.1]), &SE2::identity()).unwrap();
    let at = found.evidence.at;
    let bits = [at.x(), at.y(), at.theta(), found.evidence.noise[(2, 1)]].map(f64::to_bits);
    assert_eq!(
        bits,
        [
            0x3fb8_3712_1088_2b39,
            0x3f4a_260c_ad87_53f6,
            0x3fb9_6af9_fd8c_0f18,
            0x4112_ad35_1064_dc5f
        ],
        "{bits:#x?}"
    );
}
