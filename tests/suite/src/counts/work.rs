//! The work that is counted.
//!
//! Callgrind counts while it is inside a function whose name is asked for. So
//! each piece of work is one function that is not inlined, and no closure is
//! in it, because a closure's name contains its function's.
//!
//! Some of the work chooses its instructions by what the CPU can do, which is
//! what it can do under valgrind, too (except for AVX-512, which valgrind hides).
//! Such work is counted where there is AVX2, as on all but the oldest machines.

use std::hint::black_box;

use rusty_contract::{Frame, LidarConfig, RunConfig};
use rusty_engine::scenario_file;
use rusty_geometry::generated::free_poses;
use rusty_geometry::{SE2, Scan, World, apartment};
use rusty_sim::Sim;
use rusty_sim::noise::LidarNoise;

/// As far as the scans look.
const RANGE_MAX_M: f64 = 8.0;

/// A piece of work.
#[derive(Clone, Copy, Debug)]
pub struct Work {
    /// The name of its function.
    pub name: &'static str,
    /// What it is.
    pub what: &'static str,
    /// Whether its instructions depend on AVX2.
    pub is_wide: bool,
}

/// All of it.
pub const WORK: [Work; 5] = [
    Work {
        name: "counted_step",
        what: "1000 ticks of the Apartment's run without scans",
        is_wide: true,
    },
    Work {
        name: "counted_scan",
        what: "32 scans of the Apartment with 180 beams, without noise",
        is_wide: true,
    },
    Work {
        name: "counted_portable_scan",
        what: "the same with the instructions that every machine has",
        is_wide: false,
    },
    Work {
        name: "counted_noise",
        what: "noise and dropout for 100 scans with 180 beams",
        is_wide: true,
    },
    Work { name: "counted_digest", what: "digests of 1000 frames with 180 beams", is_wide: false },
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
        "counted_scan" | "counted_portable_scan" => {
            let world = apartment();
            let poses = free_poses(&world, 1, 32, 0.1);
            let fan = LidarConfig::default().fan();
            if name == "counted_scan" {
                let mut scan = Scan::new(fan);
                scan.take(&world, &poses[0], RANGE_MAX_M);
                counted_scan(&mut scan, &world, &poses);
            } else {
                let mut scan = Scan::portable(fan);
                scan.take(&world, &poses[0], RANGE_MAX_M);
                counted_portable_scan(&mut scan, &world, &poses);
            }
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
    let script = ["script.kind=truth-steered-patrol", "script.leg_s=12.3"].map(str::to_owned);
    let changes = [&script[..], &[format!("scan_every={scan_every}")]].concat();
    scenario_file::load("apartment", &changes).unwrap().config().unwrap()
}

#[inline(never)]
fn counted_step(sim: &mut Sim, frame: &mut Frame) {
    for _ in 0..1000 {
        let _ = black_box(sim.step(None, frame));
    }
}

#[inline(never)]
fn counted_scan(scan: &mut Scan, world: &World, poses: &[SE2]) {
    scan_from(scan, world, poses);
}

#[inline(never)]
fn counted_portable_scan(scan: &mut Scan, world: &World, poses: &[SE2]) {
    scan_from(scan, world, poses);
    // So that the two are not one function after all.
    black_box(1);
}

fn scan_from(scan: &mut Scan, world: &World, poses: &[SE2]) {
    for pose in poses {
        scan.take(world, pose, RANGE_MAX_M);
        black_box(&mut *scan);
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
    for draw in noise.at(tick, 180) {
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
        assert!(WORK.iter().all(|work| run(work.name)));
        assert!(!run("counted"));
    }

    #[test]
    fn no_name_is_part_of_another() {
        let inside = |(a, b): (&str, &str)| a != b && b.contains(a);
        let names = || WORK.iter().map(|work| work.name);
        assert!(!names().flat_map(|a| names().map(move |b| (a, b))).any(inside));
    }
}
