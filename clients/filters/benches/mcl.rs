//! `cargo bench -p rusty-filters --bench mcl`: 5,000 particles, 180 beams.
//!
//! What a scan costs while the robot is tracked and while it is lost, compared with the
//! bare look-up of the same beams for the same particles, in turns; and how that
//! compares with the 0.1 s in which the next scan comes.
#![allow(clippy::unwrap_used, reason = "a bench that cannot be set up may stop")]
#![allow(clippy::disallowed_methods, reason = "a bench reads the clock; no filter does")]

use std::hint::black_box;
use std::time::Instant;

use rusty_contract::config::LidarConfig;
use rusty_filters::likelihood_field::Ends;
use rusty_filters::mcl::{Map, Mcl, Options, Particles, Robot};
use rusty_filters::{BeamModel, Beams, LikelihoodField};
use rusty_geometry::{DiffDrive, EncoderCounts, SE2, Scan, apartment, odometry_delta};

const PARTICLES: u32 = 5000;
const SCANS: usize = 30;
/// From scan to scan, s.
const PERIOD_S: f64 = 0.1;

fn main() {
    let world = apartment();
    let lidar = LidarConfig { dropout: 0.02, ..LidarConfig::default() };
    let drive = DiffDrive::rusty();
    let robot = Robot { drive, body_radius_m: 0.11, lidar, dt_s: PERIOD_S };
    let truth = SE2::new(9.6, 3.0, 0.4);
    // It turns a little, to and fro: of a robot that stands no second scan counts.
    let turned = EncoderCounts { left: -400, right: 400 };
    let there = truth.boxplus(&odometry_delta(EncoderCounts::default(), turned, &drive));
    let mut scan = Scan::new(lidar.fan());
    let mut ranges_of = |pose: &SE2| {
        let mut ranges_m = vec![0.0; 180];
        scan.take(&world, pose, lidar.range_max_m);
        scan.write_distances_m(&mut ranges_m);
        ranges_m
    };
    let moments = [(EncoderCounts::default(), ranges_of(&truth)), (turned, ranges_of(&there))];
    let begin = |initial| {
        let (particles, particles_min) = (PARTICLES, Some(PARTICLES));
        let options = Options { particles, particles_min, ..Options::default() };
        Mcl::new(robot, Map::Plan(Box::new(world.clone())), initial, &options).unwrap()
    };
    let model = BeamModel::of_lidar(&lidar);
    let field = LikelihoodField::of_world(&world, &model, lidar.range_max_m, 0.0, 0.01);
    let (beams, mut ends) = (Beams::new(&lidar), Ends::default());
    ends.set(beams.endpoints(&moments[0].1).map(|end| end.in_body));

    let mut tracked = begin(Some(truth));
    let (mut bare_s, mut tracked_s, mut lost_s) = (Vec::new(), Vec::new(), Vec::new());
    for k in 0..SCANS {
        let (ticks, ranges_m) = &moments[k % 2];
        tracked.advance(0.0, *ticks);
        tracked_s.push(seconds(|| tracked.scan(ranges_m)));
        let particles = tracked.particles().clone();
        bare_s.push(seconds(|| look_up(&field, &ends, &particles)));
        // Its first scan: as many particles, everywhere, and the whole ladder.
        let mut lost = begin(None);
        lost.advance(0.0, EncoderCounts::default());
        lost_s.push(seconds(|| lost.scan(&moments[0].1)));
    }
    let bare_s = median(&mut bare_s);
    println!("{PARTICLES} particles, {} beams, median of {SCANS} scans", ends.count());
    for (name, took_s) in [
        ("bare look-up", bare_s),
        ("tracked", median(&mut tracked_s)),
        ("lost", median(&mut lost_s)),
    ] {
        let (ms, real, ratio) = (took_s * 1e3, PERIOD_S / took_s, took_s / bare_s);
        println!("{name:>14}: {ms:6.2} ms, {real:6.1} times real time, {ratio:5.2} of the look-up");
    }
}

fn look_up(field: &LikelihoodField, ends: &Ends, particles: &Particles) {
    for k in 0..particles.count() {
        let (position, sin, cos) = particles.place(k);
        black_box(field.steps_of_scan(ends, &position, sin, cos));
    }
}

fn seconds(work: impl FnOnce()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64()
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
