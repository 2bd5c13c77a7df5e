//! The corpus, made from real things: what the programs here write themselves.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use bytemuck::Zeroable;
use rusty_contract::answer::Message;
use rusty_contract::frame::OBSERVABLE_FROM;
use rusty_contract::log::{LogHeader, LogWriter, Source, TickRef, Trailer};
use rusty_contract::tally::TallyEntry;
use rusty_contract::{Answer, Brief, Estimate, Frame, Innovation, JoinReply, JoinRequest, Refusal};
use rusty_contract::{Reply, RunDigest, Scenario, Start, Tally, TruthKey};
use rusty_engine::scenario_file::{self, BUILT_IN};
use rusty_geometry::{SE2, Twist, places};
use rusty_sim::Sim;

use crate::repository;

/// Ticks of the runs in the corpus.
const TICKS: u64 = 6;

/// The folder of a target's inputs.
pub fn folder(target: &str) -> PathBuf {
    repository().join("tests/suite/corpus").join(target)
}

/// The inputs of a target, by name.
pub fn corpus(target: &str) -> Vec<(PathBuf, Vec<u8>)> {
    let entries = std::fs::read_dir(folder(target)).expect("the target has a folder");
    let mut paths: Vec<PathBuf> = entries.map(|e| e.expect("an entry").path()).collect();
    paths.sort();
    paths.into_iter().map(|p| (p.clone(), std::fs::read(&p).expect("a file"))).collect()
}

/// The header of a small run.
pub fn header() -> LogHeader {
    let changes = ["lidar.beams=5", "scan_every=3", "ticks=6"].map(str::to_owned);
    let loaded = scenario_file::load("hallway", &changes).expect("a built-in scenario");
    LogHeader {
        writer: "rusty-tests".to_owned(),
        source: Source::Simulated,
        config: loaded.config().expect("a built-in scenario"),
        roster: Scenario::usual_participants(),
        on_loss: loaded.scenario.on_loss,
    }
}

fn estimate(covariance: bool) -> Reply {
    let covariance = covariance.then_some([0.01, 0.0, 0.0, 0.0, 0.02, 0.0, 0.0, 0.0, 0.03]);
    let innovation = covariance.map(|_| Innovation { nis: 2.5, degrees: 4 });
    Estimate { pose_in_world: SE2::new(1.0, -2.0, 0.5), covariance, innovation }.into()
}

/// A log of that run, and its frames.
fn log() -> (Vec<u8>, Vec<Box<Frame>>) {
    let header = header();
    let mut sim = Sim::new(header.config.clone()).expect("a built-in scenario");
    let mut log = LogWriter::new(Vec::new(), Path::new("seed"), &header).expect("a header");
    let (mut digest, mut frames) = (RunDigest::default(), Vec::new());
    let key = TruthKey::from_bytes([7; 32]);
    for tick in 0..TICKS {
        let mut frame = Frame::boxed();
        let _ = sim.step(None, &mut frame);
        frame.seal(&key, Some(sim.truth()));
        let reply = if tick == 2 { Reply::Abstain } else { estimate(tick == 3) };
        digest.absorb_frame(&frame, Some(sim.truth()));
        digest.absorb_replies([reply].into_iter());
        log.tick(TickRef::new(&frame, Some(sim.truth()), &[reply], header.config.dt_s))
            .expect("memory");
        frames.push(frame);
    }
    let (run_digest, world_digest) = (digest.run(), digest.world());
    let written = log.finish(Trailer { ticks: TICKS, run_digest, world_digest }).expect("memory");
    (written, frames)
}

const CARMEN: &str = "# CARMEN Logfile\n\
    PARAM robot_frontlaser_offset 0.05\nPARAM robot_front_laser_max 20.0\n\
    ODOM 0.0 0.0 0.0 0 0 0 100.0 host 100.0\n\
    ODOM 0.1 0.0 0.01 0 0 0 100.1 host 100.1\n\
    FLASER 3 1.0 81.91 inf 0.1 0.01 0.02 0.1 0.0 0.01 100.15 host 100.2\n\
    ODOM 0.2 0.01 0.03 0 0 0 100.2 host 100.2\n\
    RLASER 1 1.0 0 0 0 0 0 0 100.2 host 100.2\n\
    FLASER 3 1.1 0.9 1.2 0.2 0.02 0.04 0.2 0.01 0.03 100.25 host 100.3\n";
const ECHOES: &str = "ODOM 0.0 0.0 0.0 0 0 0 100.0 host 100.0\n\
    FLASER 2 1.0 2.0 0.1 0.01 0.02 0.1 0.01 0.02 100.15 host 100.2\n\
    ODOM 0.1 0.01 0.02 0 0 0 1.08499e-42 host 0\n\
    ODOM 0.2 0.01 0.02 0 0 0 100.2 host 100.2\n";

fn gzip(text: &str) -> Vec<u8> {
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
    packed.write_all(text.as_bytes()).expect("memory");
    packed.finish().expect("memory")
}

fn json(value: &impl serde::Serialize) -> Vec<u8> {
    serde_json::to_vec(value).expect("memory")
}

fn starts() -> [Start; 2] {
    let header = header();
    let [estimator, scorer] = [0, 1].map(|i| Start::new(&header, i, &header.roster[i]));
    [estimator, Start { sealed_brief: Some(vec![1, 2, 255]), ..scorer }]
}

/// Answers as a participant of `answers` sends them, with what to do with each.
fn game(how: &[(u8, Message)]) -> Vec<u8> {
    let op = |(how, message): &(u8, Message)| {
        let answer = Answer::carrying(message);
        [&[*how][..], bytemuck::bytes_of(&answer)].concat()
    };
    how.iter().flat_map(op).collect()
}

/// Recordings of robots: target, name, bytes.
fn recordings(log: &[u8]) -> Vec<(&'static str, &'static str, Vec<u8>)> {
    let carmen = [
        ("plain", CARMEN.as_bytes().to_vec()),
        ("echoes", ECHOES.as_bytes().to_vec()),
        ("gz", gzip(CARMEN)),
    ];
    let carmen = carmen.into_iter().map(|(name, bytes)| ("carmen", name, bytes));
    let mcap = super::mcap::seeds(log).into_iter().map(|(name, bytes)| ("mcap", name, bytes));
    carmen.chain(mcap).collect()
}

/// All inputs that are made here: target, name, bytes. Each is accepted.
pub fn made() -> Vec<(&'static str, String, Vec<u8>)> {
    let mut all: Vec<(&str, String, Vec<u8>)> = Vec::new();
    let mut add = |target, name: &str, bytes| all.push((target, format!("real-{name}"), bytes));
    let (log, frames) = log();
    for target in ["log", "score"] {
        add(target, "run", log.clone());
    }
    for (target, name, bytes) in recordings(&log) {
        add(target, name, bytes);
    }
    for (name, text) in BUILT_IN {
        add("scenario", name, text.as_bytes().to_vec());
    }
    let sets = "seed = 7\n--set lidar.beams=9\n--set on_loss=continue\n--set script.kind=straight\n\
        --set script.v_m_s=0.5\n";
    add("scenario", "set", sets.as_bytes().to_vec());
    for name in ["open", "hallway"] {
        let spec = places::place(name).expect("a place").spec().clone();
        add("world", &format!("{name}.toml"), spec.to_toml().expect("a place").into_bytes());
        add("world", &format!("{name}.json"), json(&spec));
    }
    add("join", "request", json(&JoinRequest::new("a", 4711, 400_000, "my-filter 0.1.0")));
    let roster = vec!["a".to_owned(), "log".to_owned()];
    let refusals = [
        Refusal::Unknown { name: "ä".to_owned(), roster },
        Refusal::Layout { client: 1, server: 2 },
    ];
    for (i, refusal) in refusals.into_iter().enumerate() {
        add("reply", &format!("refusal-{i}"), json(&JoinReply::Refused(refusal)));
    }
    for (i, start) in starts().into_iter().enumerate() {
        add("reply", &format!("start-{i}"), json(&JoinReply::Start(Box::new(start))));
    }
    add(
        "brief",
        "brief",
        json(&Brief { header: header(), out_dir: Some("/tmp/x".to_owned()), report: true }),
    );
    let command = Twist { v_m_s: 0.5, omega_rad_s: -0.2 };
    let both = match estimate(true) {
        Reply::Estimate(e) => Reply::Both(e, command),
        other => other,
    };
    for (name, reply) in [("both", both), ("plain", estimate(false)), ("taken", Reply::Taken)] {
        let answer = Answer::carrying(&Message::Reply(reply));
        add("answer", name, bytemuck::bytes_of(&answer).to_vec());
    }
    let fits = (7, Message::Reply(both));
    let whole = [vec![(7, Message::Ready)], vec![fits; 4], vec![(7, Message::Leave)]].concat();
    add("answers", "whole", game(&whole));
    let [scan, plain] = [&frames[0], &frames[1]].map(|f| bytemuck::bytes_of(&**f).to_vec());
    add("frame", "scan", scan[..OBSERVABLE_FROM + 96].to_vec());
    add("frame", "plain", plain[..OBSERVABLE_FROM + 56].to_vec());
    add("tally", "one", tally(both));
    add("texts", "key", TruthKey::from_bytes([0xA7; 32]).to_hex().into_bytes());
    for text in ["lab-1", "2.5", "real", "0.5 0 2\n# turn\n0.1 -0.2 100\n"] {
        let name: String = text.chars().filter(char::is_ascii_alphanumeric).take(4).collect();
        add("texts", &name, text.as_bytes().to_vec());
    }
    let cells: Vec<u8> = (0..96).map(|k: u8| if k % 12 < 2 || k > 83 { 0 } else { 254 }).collect();
    add("map", "pgm", rusty_floorplan::map_server::pgm::write(12, 8, "0.05 m a pixel", &cells));
    add("svg", "plan", DRAWING.as_bytes().to_vec());
    all
}

/// A drawing with every element that makes a wall.
const DRAWING: &str = "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 40 30' width='400cm' \
    height='300cm'><style>.w{stroke:#111;fill:none}</style><g id='a' transform='translate(1 2)'>\
    <path class='w' d='M0 0h9v9H0z'/></g><use href='#a' x='9'/><circle class='w' r='5' cx='20' \
    cy='20'/><line class='glass' x1='1' y1='2' x2='3' y2='4'/><path id='door-3' d='M0 9Q9 0 20 9'/>\
    <polyline points='0,0 3,4' stroke='red'/></svg>\n";

/// A tally with one answer in it, up to its first entry.
fn tally(reply: Reply) -> Vec<u8> {
    let mut tally = Tally::zeroed();
    tally.begin(1, 2);
    tally.push(TallyEntry::answered(Answer::carrying(&Message::Reply(reply)), 5));
    let mut digest = RunDigest::default();
    digest.absorb_replies([reply].into_iter());
    tally.run_digest = digest.run();
    bytemuck::bytes_of(&tally)[..56 + size_of::<TallyEntry>()].to_vec()
}
