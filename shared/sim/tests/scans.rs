//! The LiDAR in the Apartment, beam by beam.

mod common;

use common::{config, sim};
use rusty_contract::{Frame, LidarConfig, ScriptConfig};
use rusty_geometry::{Hit, Material, SE2, apartment};
use rusty_sim::Lidar;

/// The sensor of the chapter's anatomy of a scan.
fn sensor() -> SE2 {
    SE2::new(4.9, 2.84, std::f64::consts::FRAC_PI_2)
}

/// Its noise-free ranges, m, rounded to 1e-9.
#[rustfmt::skip]
const ANATOMY_M: [f64; 180] = [
    2.840000000, 2.841731106, 2.846934991, 2.855643514, 2.867910306, 2.883811578, 1.676638576, 1.690206352,
    1.706091075, 1.724398048, 1.745251547, 1.768796978, 1.795203497, 1.824667182, 1.857414883, 1.893708883,
    1.933852582, 1.978197436, 2.027151483, 2.081189873, 2.140867955, 2.206837677, 2.279868289, 2.360872725,
    2.450941542, 2.551387076, 2.663801563, 2.790134651, 2.774301282, 2.712110328, 2.655811238, 2.604911117,
    2.558984463, 2.517663441, 2.480629908, 2.447608877, 2.418363116, 2.392688702, 2.370411348, 2.351383368,
    2.335481207, 2.322603417, 2.312669043, 2.305616366, 2.301401952, 2.300000000, 2.301401952, 2.305616366,
    2.312669043, 2.322603417, 2.335481207, 2.351383368, 2.370411348, 2.392688702, 2.418363116, 2.447608877,
    2.480629908, 2.517663441, 2.418042355, 2.257857736, 2.120000000, 2.000304710, 1.895589149, 1.803379714,
    1.721725400, 1.649067256, 1.584145143, 1.525929932, 1.473573406, 1.426370693, 1.383731727, 1.345159308,
    1.310232056, 1.278591025, 1.249929108, 1.223982571, 1.200524254, 1.179358057, 2.473877989, 2.437488518,
    2.405041766, 2.376304627, 2.351076725, 2.329186802, 2.310489744, 2.294864143, 2.282210314, 2.272448712,
    2.265518690, 2.261377570, 2.260000000, 2.261377570, 2.265518690, 2.272448712, 2.282210314, 2.294864143,
    2.310489744, 2.329186802, 2.351076725, 2.376304627, 2.405041766, 2.437488518, 2.473877989, 1.179358057,
    1.200524254, 1.223982571, 1.249929108, 1.278591025, 1.310232056, 1.345159308, 1.383731727, 1.426370693,
    1.473573406, 1.525929932, 1.584145143, 1.649067256, 1.721725400, 1.803379714, 1.895589149, 2.000304710,
    2.120000000, 2.257857736, 2.418042355, 2.517663441, 2.480629908, 2.447608877, 2.418363116, 2.392688702,
    2.370411348, 2.351383368, 2.335481207, 2.322603417, 2.312669043, 2.305616366, 2.301401952, 2.300000000,
    2.301401952, 2.305616366, 2.312669043, 2.322603417, 2.335481207, 2.351383368, 2.370411348, 2.392688702,
    2.418363116, 2.447608877, 2.480629908, 2.517663441, 2.558984463, 2.604911117, 2.655811238, 2.712110328,
    2.774301282, 2.842956348, 2.918741895, 3.002436765, 3.094955278, 3.197376259, 3.310980041, 3.437296065,
    3.578164802, 3.604011731, 3.510433056, 3.425658974, 3.348866666, 3.279349529, 3.216498944, 3.159789511,
    3.108767031, 3.063038669, 3.022264874, 2.986152717, 2.954450398, 2.926942707, 2.903447289, 2.883811578,
    2.867910306, 2.855643514, 2.846934991, 2.841731106,
];

fn assert_anatomy(ranges_m: impl ExactSizeIterator<Item = f64>) {
    assert_eq!(ranges_m.len(), 180);
    for (k, (found, expected)) in ranges_m.zip(ANATOMY_M).enumerate() {
        assert!((found - expected).abs() < 1e-9, "beam {k}: {found} for {expected}");
    }
}

fn hits() -> Vec<Hit> {
    let nothing = Hit { distance_m: f64::NAN, material: None };
    let mut hits = vec![nothing; 180];
    Lidar::new(&LidarConfig::default()).ranges_and_materials(&apartment(), &sensor(), &mut hits);
    hits
}

#[test]
fn the_180_ranges_of_the_anatomy() {
    assert_anatomy(hits().iter().map(|hit| hit.distance_m));
    assert_eq!(ANATOMY_M[90], 2.26);
}

#[test]
fn the_anatomy_through_a_frame() {
    // A standing robot with a perfect sensor shows the same in every scan.
    let mut config = config(ScriptConfig::Driver {}, &apartment(), sensor());
    config.robot.slip_std = 0.02;
    config.lidar.range_std_m = 0.0;
    config.scan_every = 3;
    let mut sim = sim(config);
    let mut frame = Frame::boxed();
    for tick in 0..10 {
        let _ = sim.step(None, &mut frame);
        match frame.ranges_m() {
            Some(ranges_m) => {
                assert_eq!(tick % 3, 0);
                assert_anatomy(ranges_m.iter().copied());
            }
            None => assert_ne!(tick % 3, 0),
        }
    }
}

#[test]
fn three_cliffs_and_no_more() {
    let ranges_m: Vec<f64> = hits().iter().map(|hit| hit.distance_m).collect();
    let cliffs: Vec<usize> =
        (0..179).filter(|&k| (ranges_m[k + 1] - ranges_m[k]).abs() > 0.25).collect();
    assert_eq!(cliffs, [5, 77, 102]);
    // The scan closes on itself without a fourth.
    assert!((ranges_m[179] - ranges_m[0]).abs() < 0.25);
}

#[test]
fn every_beam_says_what_it_met() {
    let hits = hits();
    assert!(hits.iter().all(|hit| hit.material.is_some()));
    assert!(hits.iter().any(|hit| hit.material == Some(Material::Wall)));
}

#[test]
fn a_sensor_off_the_centre_turns_with_the_body() {
    // Mounted so that the sensor stands where the anatomy wants it.
    let body = SE2::new(4.7, 2.9, 0.4);
    let mut config = config(ScriptConfig::Driver {}, &apartment(), body);
    config.lidar.range_std_m = 0.0;
    config.lidar.sensor_in_body = body.inverse().compose(&sensor());
    config.scan_every = 1;
    let mut sim = sim(config);
    let mut frame = Frame::boxed();
    let _ = sim.step(None, &mut frame);
    assert_anatomy(frame.ranges_m().unwrap().iter().copied());
}
