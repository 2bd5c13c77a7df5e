//! Glass, mixed pixels and noise that grows with the range: frequencies and densities
//! against laws that are computed here.
#![allow(clippy::unwrap_used, reason = "part of tests, though not of test functions")]

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use rusty_contract::LidarConfig;
use rusty_geometry::{Material, SE2, WallSpec, World, WorldSpec, apartment, trig};
use rusty_sim::Lidar;
use rusty_sim::noise::LidarNoise;

/// A world with walls across the x axis, each at x and of a material.
fn across(walls: &[(f64, Material)]) -> World {
    let wall = |&(x, material)| WallSpec { a: [x, -40.0], b: [x, 40.0], material };
    let bounds = [-50.0, -50.0, 50.0, 50.0];
    let walls = walls.iter().map(wall).collect();
    World::new(WorldSpec { name: "across".into(), bounds, walls, landmarks: Vec::new() }).unwrap()
}

/// 180 beams side by side at an angle from straight ahead, without noise.
fn bundle(angle_rad: f64) -> LidarConfig {
    LidarConfig {
        first_bearing_rad: angle_rad,
        fov_rad: 1e-6,
        range_max_m: 100.0,
        range_std_m: 0.0,
        glass_visible_rad: 0.0,
        ..LidarConfig::default()
    }
}

/// The ranges of `scans` scans from a pose, one after the other.
fn scans(config: &LidarConfig, world: &World, pose: SE2, scans: u64) -> Vec<f64> {
    let (mut lidar, mut noise) = (Lidar::new(config), LidarNoise::new(5));
    let mut all_m = Vec::new();
    for tick in 0..scans {
        let mut ranges_m = vec![f64::NAN; lidar.beams()];
        lidar.scan(world, &pose, &mut noise, tick, &mut ranges_m);
        all_m.append(&mut ranges_m);
    }
    all_m
}

fn square(x: f64) -> f64 {
    x * x
}

/// The law, in angles: Stokes' sum of the reflections between two faces, over both
/// polarisations.
fn transmission(incidence_rad: f64) -> f64 {
    let inside_rad = trig::asin(trig::sin(incidence_rad) / 1.5);
    let (less, more) = (incidence_rad - inside_rad, incidence_rad + inside_rad);
    let s = square(trig::sin(less) / trig::sin(more));
    let p = square(trig::tan(less) / trig::tan(more));
    0.5 * ((1.0 - s) / (1.0 + s) + (1.0 - p) / (1.0 + p))
}

/// Asserts that `share` of `n` draws is `expected` within three standard deviations.
fn assert_share(ranges_m: &[f64], counts: impl Fn(f64) -> bool, expected: f64) {
    let n = ranges_m.len() as f64;
    let share = ranges_m.iter().filter(|r| counts(**r)).count() as f64 / n;
    let sigma = (expected * (1.0 - expected) / n).sqrt();
    assert!((share - expected).abs() <= 3.0 * sigma, "{share} for {expected} ± {sigma}");
}

#[test]
fn panes_in_a_row_pass_the_share_of_the_law_each() {
    let world = across(&[(1.0, Material::Glass), (1.5, Material::Glass), (2.0, Material::Wall)]);
    for degrees in [10.0, 35.0, 55.0, 70.0, 80.0, 86.0] {
        let angle_rad = degrees * PI / 180.0;
        let ranges_m = scans(&bundle(angle_rad), &world, SE2::identity(), 300);
        let (share, cos) = (transmission(angle_rad), trig::cos(angle_rad));
        let at = |x: f64| move |range_m: f64| (range_m * cos - x).abs() < 1e-3;
        assert_share(&ranges_m, at(1.0), 1.0 - share);
        assert_share(&ranges_m, at(1.5), share * (1.0 - share));
        assert_share(&ranges_m, at(2.0), share * share);
    }
}

#[test]
fn a_pane_near_its_perpendicular_returns_every_beam_and_only_there() {
    let world = across(&[(1.0, Material::Glass)]);
    let at_angle = |angle_rad| {
        let config = LidarConfig { glass_visible_rad: 0.3, ..bundle(angle_rad) };
        scans(&config, &world, SE2::identity(), 200)
    };
    for angle_rad in [0.0, -0.2, 0.2999] {
        assert!(at_angle(angle_rad).iter().all(|r| *r < 1.1), "{angle_rad} rad");
    }
    // Behind it is nothing.
    assert_share(&at_angle(-0.301), |r| r == 100.0, transmission(0.301));
}

#[test]
fn only_glass_is_passed_and_eight_panes_at_most() {
    for material in [Material::Wall, Material::Door(3)] {
        let world = across(&[(1.0, material), (2.0, Material::Wall)]);
        assert!(scans(&bundle(0.6), &world, SE2::identity(), 20).iter().all(|r| *r < 1.5));
    }
    let panes: Vec<_> = (1..=12).map(|x| (f64::from(x), Material::Glass)).collect();
    let ranges_m = scans(&bundle(0.5), &across(&panes), SE2::identity(), 100);
    let cos = trig::cos(0.5);
    assert!(ranges_m.iter().all(|r| r * cos < 9.1));
    assert_share(&ranges_m, |r| r * cos > 8.9, square(square(square(transmission(0.5)))));
}

#[test]
fn what_passes_changes_no_draw_of_dropout_and_noise() {
    let noisy = LidarConfig { dropout: 0.2, ..LidarConfig::default() };
    let pose = SE2::new(9.0, 2.0, 0.4);
    let solid = scans(&noisy, &apartment(), pose, 50);
    // With glass that is seen from every angle but the last bit of the widest, the
    // bits are those of the whole scan.
    let glass_visible_rad = FRAC_PI_2.next_down();
    let checked = LidarConfig { glass_visible_rad, ..noisy };
    assert_eq!(scans(&checked, &apartment(), pose, 50), solid);
    let glass = scans(&LidarConfig { glass_visible_rad: 0.1, ..noisy }, &apartment(), pose, 50);
    let exact = |glass_visible_rad| {
        let silent = LidarConfig { range_std_m: 0.0, glass_visible_rad, ..LidarConfig::default() };
        scans(&silent, &apartment(), pose, 50)
    };
    let (walls_m, beyond_m) = (exact(FRAC_PI_2), exact(0.1));
    let mut passed = 0;
    for i in 0..solid.len() {
        if walls_m[i] == beyond_m[i] {
            assert_eq!(solid[i], glass[i], "reading {i}");
        } else {
            // The panes of the apartment lead outside.
            passed += 1;
            assert_eq!((beyond_m[i], glass[i]), (8.0, 8.0), "reading {i}");
        }
    }
    assert!(passed > 1000, "{passed}");
}

#[test]
fn the_standard_deviation_grows_with_the_range() {
    for (range_std_m, range_std_per_m) in [(0.01, 0.0), (0.0, 0.01), (0.01, 0.005)] {
        for x in [0.5, 2.0, 8.0, 30.0] {
            let config = LidarConfig { range_std_m, range_std_per_m, ..bundle(0.0) };
            let world = across(&[(x, Material::Wall)]);
            let ranges_m = scans(&config, &world, SE2::identity(), 200);
            let n = ranges_m.len() as f64;
            let expected = square(range_std_m) + square(range_std_per_m * x);
            let variance = ranges_m.iter().map(|r| square(r - x)).sum::<f64>() / n;
            let sigma = expected * (2.0 / n).sqrt();
            assert!((variance - expected).abs() < 3.0 * sigma, "{variance} for {expected}");
        }
    }
}

/// A wall 2 m ahead that ends on the x axis, and another 5 m ahead.
fn edge() -> World {
    let wall = |a, b| WallSpec { a, b, material: Material::Wall };
    let walls = vec![wall([2.0, 0.0], [2.0, 3.0]), wall([5.0, -9.0], [5.0, 9.0])];
    let bounds = [-10.0, -10.0, 10.0, 10.0];
    World::new(WorldSpec { name: "edge".into(), bounds, walls, landmarks: Vec::new() }).unwrap()
}

#[test]
fn mixed_pixels_are_as_many_as_the_beam_is_wide_and_evenly_between() {
    let divergence_rad = 0.016;
    // Beams over ±0.05 rad, evenly by bearing: the edge is anywhere in a footprint.
    let thin = LidarConfig {
        beams: 1000,
        first_bearing_rad: -0.05,
        fov_rad: 0.1,
        range_std_m: 0.0,
        ..LidarConfig::default()
    };
    let wide = LidarConfig { divergence_rad, ..thin };
    let mut levels = [0_u32; 17];
    for k in 0..40 {
        let pose = SE2::new(0.0, 0.0, 2.5e-6 * f64::from(k));
        let before_m = scans(&thin, &edge(), pose, 1);
        for (mixed_m, exact_m) in scans(&wide, &edge(), pose, 1).into_iter().zip(before_m) {
            if mixed_m == exact_m {
                continue;
            }
            // Sixteenths of the footprint on the far wall; both are nearly flat here.
            let level = (mixed_m - 2.0) / 3.0 * 16.0;
            assert!((level - level.round()).abs() < 0.02, "{mixed_m} m");
            levels[level.round() as usize] += 1;
        }
    }
    assert_eq!((levels[0], levels[16]), (0, 0));
    // 10 beams per 1 mrad, and each level is a sixteenth of the 16 mrad: 400 in all.
    for (level, count) in levels.iter().enumerate().take(16).skip(1) {
        assert!((398..=402).contains(count), "level {level}: {count}");
    }
}

#[test]
fn a_wide_beam_reads_what_returns_and_the_middle_where_there_is_no_edge() {
    let pane = across(&[(1.0, Material::Glass)]);
    let wide = LidarConfig { divergence_rad: 0.1, beams: 1, ..bundle(0.0) };
    let off = LidarConfig { divergence_rad: 0.0, ..wide };
    let pose = SE2::new(0.0, 0.0, 0.7);
    // All rays of a beam have one draw: it passes the pane as a whole, or not, but for
    // draws between the shares of its outermost rays.
    let [wide_m, thin_m] = [wide, off].map(|config| scans(&config, &pane, pose, 300));
    let same = wide_m.iter().zip(&thin_m).filter(|(a, b)| a == b).count();
    assert!((290..300).contains(&same), "{same}");
    // The far wall is out of reach: what returns is the near one, up to its edge.
    let config = LidarConfig { range_max_m: 4.0, range_std_m: 0.0, ..LidarConfig::default() };
    let config = LidarConfig { divergence_rad: 0.1, beams: 1, first_bearing_rad: 0.0, ..config };
    for (bearing_rad, expected_m) in [(0.04, 2.0), (-0.04, 2.0), (-0.06, 4.0), (TAU / 2.0, 4.0)] {
        let range_m = scans(&config, &edge(), SE2::new(0.0, 0.0, bearing_rad), 1)[0];
        assert!((range_m - expected_m).abs() < 0.01, "{bearing_rad} rad: {range_m} m");
    }
}
