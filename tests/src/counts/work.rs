//! The work that is counted.
//!
//! Callgrind counts while it is inside a function whose name is asked for. So
//! each piece of work is one function that is not inlined, and no closure lies
//! in it, because a closure's name contains its function's. What the machine's
//! vector units could change is left out: the scan takes the portable path, and
//! the generator of noise and the digest choose theirs when they are compiled.

use std::hint::black_box;

use rusty_contract::{Frame, LidarConfig, RunConfig};
use rusty_geometry::generated::free_poses;
use rusty_geometry::{Hit, SE2, World, apartment};
use rusty_sim::noise::LidarNoise;
use rusty_sim::{Lidar, Sim};
use sim_server::scenario_file;

/// Each piece of work: the name of its function, and what it is.
pub const WORK: [(&str, &str); 4] = [
    ("counted_step", "1000 ticks of the Apartment's run without scans"),
    ("counted_scan", "32 scans of the Apartment with 180 beams, without noise"),
    ("counted_noise", "noise and dropout for 100 scans with 180 beams"),
    ("counted_digest", "digests of 1000 frames with 180 beams"),
];

/// Does one piece of work, and a little of it beforehand, so that nothing that
/// happens only once is counted. `false` if there is none of this name.
#[must_use]
pub fn run(name: &str) -> bool {
    match name {
        "counted_step" => {
            let (mut sim, mut frame) = (Sim::new(config(0)).unwrap(), Frame::boxed());
            let _ = sim.step(None, &mut frame);
            counted_step(&mut sim, &mut frame);
        }
        "counted_scan" => {
            let world = apartment();
            let poses = free_poses(&world, 1, 32, 0.1);
            let lidar = Lidar::new(&LidarConfig::default());
            let mut hits = vec![Hit { distance_m: 0.0, material: None }; lidar.beams()];
            lidar.ranges_and_materials(&world, &poses[0], &mut hits);
            counted_scan(&lidar, &world, &poses, &mut hits);
        }
        "counted_noise" => {
            let mut noise = LidarNoise::new(1);
            noise_of_a_scan(&mut noise, 0);
            counted_noise(&mut noise);
        }
        "counted_digest" => {
            let (mut sim, mut frame) = (Sim::new(config(1)).unwrap(), Frame::boxed());
            let _ = sim.step(None, &mut frame);
            black_box(frame.observable_digest());
            counted_digest(&frame);
        }
        _ => return false,
    }
    true
}

fn config(scan_every: u64) -> RunConfig {
    let changes = [format!("scan_every={scan_every}")];
    scenario_file::load("apartment", &changes).unwrap().config().unwrap()
}

#[inline(never)]
fn counted_step(sim: &mut Sim, frame: &mut Frame) {
    for _ in 0..1000 {
        let _ = black_box(sim.step(None, frame));
    }
}

#[inline(never)]
fn counted_scan(lidar: &Lidar, world: &World, poses: &[SE2], hits: &mut [Hit]) {
    for pose in poses {
        lidar.ranges_and_materials(world, pose, hits);
        black_box(&mut *hits);
    }
}

#[inline(never)]
fn counted_noise(noise: &mut LidarNoise) {
    for tick in 1..=100 {
        noise_of_a_scan(noise, tick);
    }
}

#[inline(always)]
fn noise_of_a_scan(noise: &mut LidarNoise, tick: u64) {
    for draw in noise.at(tick).take(180) {
        black_box(draw);
    }
}

#[inline(never)]
fn counted_digest(frame: &Frame) {
    for _ in 0..1000 {
        black_box(black_box(frame).observable_digest());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_piece_of_work_can_be_done_and_no_other() {
        assert!(WORK.iter().all(|(name, _)| run(name)));
        assert!(!run("counted"));
    }

    #[test]
    fn no_name_is_part_of_another() {
        let inside = |(a, b): (&str, &str)| a != b && b.contains(a);
        let names = || WORK.iter().map(|(name, _)| *name);
        assert!(!names().flat_map(|a| names().map(move |b| (a, b))).any(inside));
    }
}
