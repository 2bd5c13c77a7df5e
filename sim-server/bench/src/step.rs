//! `bench step`: what a tick costs before it is sent, part by part.
//!
//! One tick of the world without a scan and with one, the digest of a frame and
//! its seal, compared with two things that are well known: copying a frame and
//! taking a sine and a cosine.

use std::hint::black_box;
use std::time::Duration;

use rusty_contract::digest::RunDigest;
use rusty_contract::{Estimate, Frame, Reply, RunConfig, TruthKey};
use rusty_geometry::{SE2, trig};
use rusty_sim::Sim;

use super::alternate::{Rival, alternate};
use super::results::{Results, Row};
use crate::error::BenchError;
use rusty_engine::scenario_file;

/// Ticks of the run whose digest is printed.
const DIGEST_TICKS: usize = 1000;

/// The parts, in the order of the table; the first two are what the others are
/// compared with.
pub const PARTS: [&str; 9] = [
    "copy of a frame",
    "one sine and cosine",
    "tick without a scan",
    "tick with a scan of 180 beams",
    "tick with a scan of 1080 beams",
    "digest of a frame with 180 beams",
    "digest of a frame with 1080 beams",
    "digest and seal of a frame with 180 beams",
    "run digest of a frame and three replies",
];

/// Returns the names of the rows.
#[must_use]
pub fn rows() -> Vec<String> {
    PARTS.map(str::to_owned).to_vec()
}

/// Measures for about `time`.
///
/// # Errors
/// None that the built-in scenario can cause.
pub fn run(time: Duration) -> Result<Results, BenchError> {
    let (few, many) = (scanned(180)?, scanned(1080)?);
    let mut rivals = [
        copy(),
        sine(),
        ticks(sim(0, 180)?, 500),
        ticks(sim(1, 180)?, 20),
        ticks(sim(1, 1080)?, 5),
        digest(few.clone()),
        digest(many),
        seal(few.clone()),
        run_digest(few),
    ];
    let rounds = alternate(&mut rivals, time);
    let [copy, sine, ..] = &rivals;
    let parts = PARTS.iter().zip(&rivals).map(|(name, rival)| {
        let row = Row::new(*name).with("ns", rival.ns());
        row.with("over_copy", rival.over(copy)).with("over_sine", rival.over(sine))
    });
    let results = Results::new(&[&[("ns", 1), ("over_copy", 2), ("over_sine", 1)]], parts);
    Ok(results.fact("rounds", rounds).fact("world_digest", world_digest()?))
}

/// The Apartment's run, steered so that no wall stops the robot.
fn config(scan_every: u64, beams: u32) -> Result<RunConfig, BenchError> {
    let script = ["script.kind=truth-steered-patrol", "script.leg_s=12.3"].map(str::to_owned);
    let changes = [format!("scan_every={scan_every}"), format!("lidar.beams={beams}")];
    let changes = [script, changes].concat();
    Ok(scenario_file::load("apartment", &changes)?.config()?)
}

fn sim(scan_every: u64, beams: u32) -> Result<Sim, BenchError> {
    Ok(Sim::new(config(scan_every, beams)?)?)
}

/// A frame with a scan.
fn scanned(beams: u32) -> Result<Box<Frame>, BenchError> {
    let (mut sim, mut frame) = (sim(1, beams)?, Frame::boxed());
    let _ = sim.step(None, &mut frame);
    Ok(frame)
}

/// Digest of frames and truths of a run: the same on every machine.
fn world_digest() -> Result<String, BenchError> {
    let (mut sim, mut frame) = (sim(5, 180)?, Frame::boxed());
    let (key, mut digest) = (TruthKey::from_bytes([0; 32]), RunDigest::default());
    for _ in 0..DIGEST_TICKS {
        let _ = sim.step(None, &mut frame);
        frame.seal(&key, Some(sim.truth()));
        digest.absorb_frame(&frame, Some(sim.truth()));
    }
    Ok(digest.world_hex())
}

/// A rival whose batch does the same thing `count` times.
fn repeated(count: usize, mut once: impl FnMut() + 'static) -> Rival<'static> {
    Rival::new(count, move || (0..count).for_each(|_| once()))
}

fn copy() -> Rival<'static> {
    let (from, mut to) = (Frame::boxed(), Frame::boxed());
    repeated(100, move || {
        *to = *black_box(&*from);
        black_box(&mut *to);
    })
}

fn sine() -> Rival<'static> {
    let mut angle_rad = 0.0;
    repeated(1000, move || {
        // Angles of every quadrant, none of them far out.
        angle_rad = if angle_rad > 3.0 { -3.0 } else { angle_rad + 0.01 };
        black_box(trig::sin_cos(black_box(angle_rad)));
    })
}

fn ticks(mut sim: Sim, batch: usize) -> Rival<'static> {
    let mut frame = Frame::boxed();
    repeated(batch, move || {
        let _ = black_box(sim.step(None, &mut frame));
        black_box(&frame);
    })
}

fn digest(frame: Box<Frame>) -> Rival<'static> {
    repeated(100, move || {
        black_box(black_box(&frame).observable_digest());
    })
}

fn seal(mut frame: Box<Frame>) -> Rival<'static> {
    let (key, pose) = (TruthKey::from_bytes([0; 32]), SE2::new(1.0, 2.0, 3.0));
    repeated(100, move || {
        frame.seal(&key, Some(pose));
        black_box(&mut frame);
    })
}

fn run_digest(frame: Box<Frame>) -> Rival<'static> {
    let pose = SE2::new(1.0, 2.0, 3.0);
    let replies = [Reply::Estimate(Estimate::from(pose)), Reply::Taken, Reply::Taken];
    let mut digest = RunDigest::default();
    repeated(100, move || {
        digest.absorb_frame(black_box(&frame), Some(pose));
        digest.absorb_replies(black_box(replies).into_iter());
        black_box(&digest);
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_part_is_measured_and_the_digest_is_the_run_s() {
        let results = run(Duration::ZERO).unwrap();
        let names: Vec<&str> = results.rows.iter().map(|row| row.name.as_str()).collect();
        assert_eq!(names, PARTS);
        assert!(results.rows.iter().all(|row| row.number("ns") > 0.0));
        let digest = world_digest().unwrap();
        assert_eq!((results.facts["world_digest"].as_str(), digest.len()), (Some(&*digest), 32));
    }
}
