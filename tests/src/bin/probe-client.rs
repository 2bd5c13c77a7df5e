//! A participant that misbehaves on request, for tests of the server. It
//! speaks through the link directly, past the checks of the SDK.

use std::sync::atomic::AtomicBool;
use std::time::Duration;

use clap::Parser;
use rusty_clients::dead_reckoning::DeadReckoning;
use rusty_contract::answer::Message;
use rusty_contract::{Answer, Estimate, Exit, JoinRequest, Phase, Reply, RunName};
use rusty_geometry::{SE2, Twist};
use rusty_link::{BorrowedFrame, ClientLink, Incoming, LinkError, WaitPolicy};

#[derive(Parser)]
struct Cli {
    #[arg(long)]
    run: RunName,
    #[arg(long)]
    name: String,
    #[arg(long, default_value_t)]
    wait: WaitPolicy,
    /// What to do instead of dead reckoning: slow, abstain, nan-estimate,
    /// nan-command, future-tick, old-tick, double, wrong-digest,
    /// pause (sleeps once, for sleep-us), exit, abort, panic, hang, goodbye, wrong-layout,
    /// wrong-protocol, wrong-pid, covariance, linger, flood (with answers that
    /// nobody asked for), forge (answers for all others), fickle-and-mortal
    /// (says something else in every life, and exits in its first)
    #[arg(long, default_value = "")]
    mode: String,
    /// From which tick on
    #[arg(long, default_value_t = 10)]
    at: u64,
    /// Longest sleep of mode slow, the one sleep of mode pause, µs
    #[arg(long, default_value_t = 2000)]
    sleep_us: u64,
    /// Sleep before joining, ms
    #[arg(long, default_value_t = 0)]
    late_ms: u64,
    #[arg(long)]
    key_stdin: bool,
}

fn main() -> Exit {
    let cli = Cli::parse();
    std::thread::sleep(Duration::from_millis(cli.late_ms));
    let stop = AtomicBool::new(false);
    let mut request = JoinRequest::new(&cli.name, std::process::id(), cli.wait.awake_ns(), "probe");
    match cli.mode.as_str() {
        "wrong-layout" => request.layout ^= 1,
        "wrong-protocol" => request.protocol += 1,
        "wrong-pid" => request.pid = std::os::unix::process::parent_id(),
        _ => {}
    }
    let joined = ClientLink::join(&cli.run, &request, cli.wait, Duration::from_secs(20), &stop);
    match joined.and_then(|mut link| take_part(&cli, &mut link, &stop)) {
        Ok(()) => Exit::Done,
        Err(e) => {
            eprintln!("probe: {e}");
            Exit::Failed
        }
    }
}

fn take_part(cli: &Cli, link: &mut ClientLink, stop: &AtomicBool) -> Result<(), LinkError> {
    let start = link.start().clone();
    let mut odometry =
        DeadReckoning::new(start.robot.drive, start.initial_pose.unwrap_or_default());
    let mut dice = 0x1234_5678_9ABC_DEF0u64;
    loop {
        let Incoming::Frame(frame) = link.wait_frame(Duration::from_millis(500), stop)? else {
            continue;
        };
        if frame.phase() != Phase::Tick {
            if cli.mode == "linger" {
                std::thread::sleep(Duration::from_secs(600));
            }
            return link.send_raw(Answer::carrying(&Message::Goodbye));
        }
        let pose = odometry.advance(frame.ticks());
        let mut reply = Reply::from(pose);
        if cli.mode == "slow" {
            dice ^= dice << 13;
            dice ^= dice >> 7;
            dice ^= dice << 17;
            std::thread::sleep(Duration::from_micros(dice % cli.sleep_us));
        }
        if cli.mode == "fickle-and-mortal" {
            reply = SE2::new(f64::from(std::process::id()), 0.0, 0.0).into();
        }
        if cli.mode == "covariance" {
            let covariance = Some([0.01, 0.0, 0.0, 0.0, 0.02, 0.0, 0.0, 0.0, 0.03]);
            reply = Estimate { pose_in_world: pose, covariance }.into();
        }
        if frame.tick() < cli.at {
            link.answer(&frame, &Message::Reply(reply))?;
        } else if cli.mode == "goodbye" {
            return link.send_raw(Answer::carrying(&Message::Goodbye));
        } else {
            misbehave(cli, link, &frame, reply)?;
        }
    }
}

/// Answers one frame, or not, as the mode says.
fn misbehave(
    cli: &Cli,
    link: &mut ClientLink,
    frame: &BorrowedFrame,
    mut reply: Reply,
) -> Result<(), LinkError> {
    let mut raw = Answer::carrying(&Message::Reply(reply));
    raw.tick = frame.tick();
    raw.digest_seen = frame.digest();
    match cli.mode.as_str() {
        "abstain" => reply = Reply::Abstain,
        "nan-estimate" => reply = SE2::new(f64::NAN, 0.0, 0.0).into(),
        "nan-command" => reply = Twist { v_m_s: f64::NAN, omega_rad_s: 0.0 }.into(),
        "future-tick" => raw.tick += 1,
        "old-tick" => raw.tick -= 1,
        "wrong-digest" => raw.digest_seen ^= 1,
        "double" => link.send_raw(raw)?,
        "flood" => {
            raw.tick -= 1;
            for _ in 0..400 {
                link.send_raw(raw)?;
            }
        }
        "forge" => forge(link, frame)?,
        "pause" if frame.tick() == cli.at => {
            std::thread::sleep(Duration::from_micros(cli.sleep_us));
        }
        "exit" => std::process::exit(7),
        "fickle-and-mortal" if link.start().catch_up.is_none() => std::process::exit(7),
        "abort" => std::process::abort(),
        "panic" => panic!("on request"),
        "hang" => std::thread::sleep(Duration::from_secs(600)),
        _ => {}
    }
    if matches!(cli.mode.as_str(), "future-tick" | "old-tick" | "wrong-digest") {
        link.send_raw(raw)
    } else {
        link.answer(frame, &Message::Reply(reply))
    }
}

/// Says for everyone but itself all that could end their part.
fn forge(link: &mut ClientLink, frame: &BorrowedFrame) -> Result<(), LinkError> {
    let (own, run_id) = (link.start().participant, link.start().run_id);
    for message in [Message::Failed, Message::Goodbye, Message::Reply(Reply::Abstain)] {
        for participant in (0..8).filter(|seat| *seat != own) {
            let mut answer = Answer::carrying(&message);
            answer.run_id = run_id;
            answer.participant = participant;
            answer.tick = frame.tick();
            answer.digest_seen = frame.digest();
            link.send_forged(answer)?;
        }
    }
    Ok(())
}
