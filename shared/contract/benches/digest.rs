//! `cargo bench -p rusty-contract`: digest and seal of a frame, the run digest of
//! a tick, and the four tags of a tick with one client.

use std::hint::black_box;

use criterion::{Criterion, Throughput};
use rusty_contract::answer::Message;
use rusty_contract::digest::RunDigest;
use rusty_contract::{Answer, Estimate, Frame, ParticipantKey, Reply, TruthKey};
use rusty_geometry::{EncoderCounts, SE2, Twist};

fn frame(beams: usize) -> Box<Frame> {
    let mut frame = Frame::boxed();
    frame.begin(7, 0.16, EncoderCounts { left: 3, right: 4 }, Twist::default());
    if beams > 0 {
        frame.write_scan(beams).iter_mut().zip(1..).for_each(|(r, k)| *r = 8.0 / f64::from(k));
    }
    frame
}

fn main() {
    let mut criterion = Criterion::default().configure_from_args();
    let (key, pose) = (TruthKey::from_bytes([7; 32]), SE2::new(1.0, 2.0, 0.5));
    for beams in [0, 180, 1080] {
        let mut frame = frame(beams);
        let mut group = criterion.benchmark_group(format!("frame of {beams} beams"));
        group.throughput(Throughput::Bytes(frame.observable().len() as u64));
        group.bench_function("digest", |bencher| {
            bencher.iter(|| black_box(&frame).observable_digest());
        });
        group.bench_function("digest and seal", |bencher| {
            bencher.iter(|| black_box(&mut frame).seal(&key, Some(pose)));
        });
        group.finish();
    }

    let (frame, mut digest) = (frame(180), RunDigest::default());
    let replies = [Reply::Estimate(Estimate::from(pose)), Reply::Taken, Reply::Taken];
    criterion.bench_function("run digest of a tick", |bencher| {
        bencher.iter(|| {
            digest.absorb_frame(black_box(&frame), Some(pose));
            digest.absorb_replies(black_box(replies).into_iter());
        });
    });

    let (mut frame, shared) = (frame, ParticipantKey::of_slot(&key, 0));
    let mut answer = Answer::carrying(&Message::Reply(replies[0]));
    criterion.bench_function("tags of a tick", |bencher| {
        bencher.iter(|| {
            black_box(&mut frame).sign(0, &shared.from_server);
            let frame_is_signed = black_box(&frame).is_signed_for(0, &shared.from_server);
            black_box(&mut answer).sign(&shared.to_server);
            frame_is_signed & black_box(&answer).is_signed_by(&shared.to_server)
        });
    });
    criterion.final_summary();
}
