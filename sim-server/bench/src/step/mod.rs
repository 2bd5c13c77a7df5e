//! `bench step`: what a tick costs before it is sent, part by part.
//!
//! One tick of the world without a scan and with one, the digest of a frame and
//! its seal, beside two things that everyone has an idea of: copying a frame and
//! taking a sine and a cosine.
//!
//! * [`results`]: what a run of the bench comes to;
//! * [`section`]: the same, on the page.

pub mod results;
pub mod section;

use std::hint::black_box;
use std::time::Duration;

use rusty_contract::digest::RunDigest;
use rusty_contract::{Frame, RunConfig, TruthKey};
use rusty_geometry::trig;
use rusty_sim::Sim;

use super::alternate::{Rival, alternate};
use crate::error::BenchError;
use results::{Part, StepResults};
use rusty_engine::scenario_file;

/// Ticks of the run whose digest is printed.
const DIGEST_TICKS: usize = 1000;

/// The parts, in the order of the table; the first two are what the others are
/// compared with.
pub const PARTS: [&str; 9] = [
    "copy of a frame (8760 bytes)",
    "one sine and cosine",
    "tick without a scan",
    "tick with a scan of 180 beams",
    "tick with a scan of 1080 beams",
    "digest of a frame with 180 beams",
    "digest of a frame with 1080 beams",
    "digest and seal of a frame with 180 beams",
    "run digest of a frame and three replies",
];

/// Measures for about `time`.
///
/// # Errors
/// None that the built-in scenario can cause.
pub fn run(time: Duration) -> Result<StepResults, BenchError> {
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
    let parts = PARTS.iter().zip(&rivals).map(|(name, rival)| Part {
        name: (*name).to_owned(),
        ns: rival.ns(),
        over_copy: rival.over(copy),
        over_sine: rival.over(sine),
    });
    Ok(StepResults { rounds, parts: parts.collect(), world_digest: world_digest()? })
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

fn copy() -> Rival<'static> {
    let (from, mut to) = (Frame::boxed(), Frame::boxed());
    Rival::new(100, move || {
        for _ in 0..100 {
            *to = *black_box(&*from);
            black_box(&mut *to);
        }
    })
}

fn sine() -> Rival<'static> {
    let mut angle_rad = 0.0;
    Rival::new(1000, move || {
        for _ in 0..1000 {
            // Angles of every quadrant, none of them far out.
            angle_rad = if angle_rad > 3.0 { -3.0 } else { angle_rad + 0.01 };
            black_box(trig::sin_cos(black_box(angle_rad)));
        }
    })
}

fn ticks(mut sim: Sim, batch: usize) -> Rival<'static> {
    let mut frame = Frame::boxed();
    Rival::new(batch, move || {
        for _ in 0..batch {
            let _ = black_box(sim.step(None, &mut frame));
        }
        black_box(&frame);
    })
}

fn digest(frame: Box<Frame>) -> Rival<'static> {
    Rival::new(100, move || {
        for _ in 0..100 {
            black_box(black_box(&frame).observable_digest());
        }
    })
}

fn seal(mut frame: Box<Frame>) -> Rival<'static> {
    let (key, pose) = (TruthKey::from_bytes([0; 32]), rusty_geometry::SE2::new(1.0, 2.0, 3.0));
    Rival::new(100, move || {
        for _ in 0..100 {
            frame.seal(&key, Some(pose));
            black_box(&mut frame);
        }
    })
}

fn run_digest(frame: Box<Frame>) -> Rival<'static> {
    use rusty_contract::{Estimate, Reply};
    let pose = rusty_geometry::SE2::new(1.0, 2.0, 3.0);
    let replies = [Reply::Estimate(Estimate::from(pose)), Reply::Taken, Reply::Taken];
    let mut digest = RunDigest::default();
    Rival::new(100, move || {
        for _ in 0..100 {
            digest.absorb_frame(black_box(&frame), Some(pose));
            digest.absorb_replies(black_box(replies).into_iter());
        }
        black_box(&digest);
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_part_is_measured_and_the_digest_is_the_run_s() {
        let results = run(Duration::ZERO).unwrap();
        let names: Vec<&str> = results.parts.iter().map(|part| part.name.as_str()).collect();
        assert_eq!(names, PARTS);
        assert!(results.parts.iter().all(|part| part.ns.min > 0.0));
        assert_eq!(results.world_digest, world_digest().unwrap());
        assert_eq!(results.world_digest.len(), 32);
    }
}
