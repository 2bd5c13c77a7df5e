//! The ladder: which rung a scan is weighed on, and what it says there.

use super::*;
use crate::Random;
use nalgebra::{Matrix3, Vector3};
use rusty_contract::config::LidarConfig;
use rusty_geometry::{SE2, apartment};

const HERE: [f64; 3] = [9.6, 3.0, 0.4];

fn how(rays: bool) -> Use {
    Use { skip: 1, exponent: 1.0, rays }
}

fn sensor(model: BeamModel, how: Use) -> Sensor {
    let lidar = LidarConfig::default();
    Sensor::of_world(&apartment(), model, Beams::new(&lidar), Scan::new(lidar.fan()), how)
}

fn sheet() -> BeamModel {
    BeamModel::of_lidar(&LidarConfig { dropout: 0.02, ..LidarConfig::default() })
}

/// A scan without errors.
fn ranges_m() -> Vec<f64> {
    let lidar = LidarConfig::default();
    let (mut scan, mut ranges_m) = (Scan::new(lidar.fan()), vec![0.0; 180]);
    scan.take(&apartment(), &SE2::new(HERE[0], HERE[1], HERE[2]), lidar.range_max_m);
    scan.write_distances_m(&mut ranges_m);
    ranges_m
}

/// Particles around the truth, `sigma` m and rad wide.
fn around(sigma: f64) -> Particles {
    let (mut particles, mut random) = (Particles::default(), Random::new(1, 1));
    let covariance = Matrix3::from_diagonal(&Vector3::repeat(sigma * sigma));
    let here = SE2::new(HERE[0], HERE[1], HERE[2]);
    particles.push_normal(&here, &covariance, 2000, &mut random);
    particles.level();
    particles
}

#[test]
fn a_sensor_that_is_blurred_already_has_one_rung() {
    let worlds = [0.02, 0.1, 0.3, 0.5, 10.0].map(|sigma_hit_m| {
        let sensor = sensor(BeamModel { sigma_hit_m, ..sheet() }, how(false));
        (sensor.fields.len(), sensor)
    });
    assert_eq!(worlds.each_ref().map(|(rungs, _)| *rungs), [5, 3, 1, 1, 1]);
    let map = OccupancyMap::of_world(&apartment(), 0.2, 0.5);
    let distances = DistanceField::of_map(&map);
    let beams = Beams::new(&LidarConfig::default());
    let cells = Sensor::of_map(&map, &distances, &sheet(), beams, how(false));
    assert_eq!(cells.fields.len(), 1);
    for mut sensor in worlds.into_iter().map(|(_, sensor)| sensor).chain([cells]) {
        let mut particles = around(0.5);
        let weighed = sensor.weigh(&ranges_m(), &mut particles).unwrap();
        assert!(weighed.beam_likelihood > 0.0 && weighed.spread.0.is_finite(), "{weighed:?}");
        assert!((particles.weights.iter().sum::<f64>() - 1.0).abs() < 1e-9);
        assert!(sensor.expected_likelihood().is_finite());
    }
}

#[test]
fn the_rungs_of_a_ladder_double() {
    let sensor = sensor(sheet(), how(false));
    let sigmas: Vec<f64> = sensor.fields.iter().map(LikelihoodField::sigma_m).collect();
    for (rung, sigma_m) in sigmas.iter().enumerate() {
        let wanted = 0.02 * f64::from(1 << rung);
        assert!((sigma_m - wanted).abs() < 1e-12, "{sigmas:?}");
    }
}

#[test]
fn particles_that_lie_apart_are_weighed_on_lower_rungs() {
    let mut sensor = sensor(sheet(), how(false));
    let mut widths = Vec::new();
    for sigma in [0.002, 0.03, 0.3, 3.0] {
        let mut particles = around(sigma);
        let weighed = sensor.weigh(&ranges_m(), &mut particles).unwrap();
        let left = effective_size(&particles.weights);
        assert!(left >= SURVIVORS * 2000.0, "{sigma}: {left} are left");
        widths.push(weighed.spread.0);
    }
    assert_eq!(widths[0], 0.0, "a tracked robot stands at the top");
    assert!(widths.is_sorted() && 0.0 < widths[1] && widths[1] < widths[2], "{widths:?}");
}

#[test]
fn skipping_beams_and_a_power_flatten_what_a_scan_says() {
    // ln of the ratio of the best to the worst weight, near the truth.
    let steepness = |how: Use| {
        let mut particles = around(0.002);
        let weighed = sensor(sheet(), how).weigh(&ranges_m(), &mut particles).unwrap();
        assert_eq!(weighed.spread.0, 0.0);
        let most = particles.weights.iter().copied().fold(0.0, f64::max);
        let least = particles.weights.iter().copied().fold(1.0, f64::min);
        trig::ln(most / least)
    };
    let all = steepness(how(false));
    let half = steepness(Use { exponent: 0.5, ..how(false) });
    assert!((half / all - 0.5).abs() < 1e-9, "{half} of {all}");
    let third = steepness(Use { skip: 3, ..how(false) });
    assert!((third / all - 1.0 / 3.0).abs() < 0.2, "{third} of {all}");
}

#[test]
fn the_beam_model_expects_what_it_finds() {
    let (model, range_max_m, expected_m) = (sheet(), 8.0, 3.0);
    let (mut random, mut sum, count) = (Random::new(5, 1), 0.0, 200_000);
    for _ in 0..count {
        let u = random.uniform();
        let range_m = if u < model.z_hit {
            expected_m + model.sigma_hit_m * random.normal()
        } else if u < model.z_hit + model.z_max {
            range_max_m
        } else {
            range_max_m * random.uniform()
        };
        sum += trig::ln(model.density(range_m, expected_m, range_max_m));
    }
    let said = trig::ln(sensor(model, how(true)).expected_likelihood());
    let found = sum / f64::from(count);
    assert!((found - said).abs() < 0.02, "{found} for {said}");
}

#[test]
fn what_is_in_front_of_the_walls_does_not_make_a_scan_less_likely() {
    let mut sensor = sensor(sheet(), how(false));
    let (here, particles) = (SE2::new(HERE[0], HERE[1], HERE[2]), around(0.002));
    let mut known = |ranges_m: &[f64]| {
        let likelihood = sensor.beam_likelihood(ranges_m, &particles).unwrap();
        (likelihood, sensor.without_hidden(ranges_m, &here, likelihood))
    };
    let clear = ranges_m();
    let (likelihood, of_clear) = known(&clear);
    assert_eq!(of_clear, likelihood);
    // People half a metre in front of the robot; the others see the same as before.
    let person = |beam: &usize| !beam.is_multiple_of(3) && clear[*beam] > 0.8;
    let crowd: Vec<f64> =
        (0..180).map(|beam| if person(&beam) { 0.5 } else { clear[beam] }).collect();
    let (with, without) = known(&crowd);
    assert!(with < 0.2 * likelihood, "{with} of {likelihood}");
    assert!((without / likelihood - 1.0).abs() < 0.1, "{without} of {likelihood}");
    // Through a wall.
    let through: Vec<f64> =
        (0..180).map(|beam| clear[beam] + if person(&beam) { 0.5 } else { 0.0 }).collect();
    let (with, without) = known(&through);
    assert!(without < 0.3 * likelihood, "{without} of {likelihood}, {with}");
    // Where all are in front, a third of them counts.
    let (with, without) = known(&[0.15; 180]);
    assert!((without / with - 1.0).abs() < 1e-9, "{without} of {with}");
}

#[test]
fn the_beam_model_reads_what_is_no_range_as_all_others_do() {
    let logs = |first: f64| {
        let mut sensor = sensor(sheet(), how(true));
        let mut ranges_m = ranges_m();
        ranges_m[0] = first;
        let beams = sensor.look_sharply(&ranges_m, &around(0.002));
        (beams, sensor.logs[0])
    };
    // Nothing came back, however that is written.
    assert_eq!(logs(f64::INFINITY), logs(8.0));
    assert_eq!(logs(8.0).0, 180.0);
    // No reading at all.
    assert_eq!(logs(-1.0), logs(f64::NAN));
    assert_eq!(logs(-1.0).0, 179.0);
}
