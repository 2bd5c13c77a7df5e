//! A participant that misbehaves on request, for tests of the server and of the
//! conformance kit. It speaks through the link directly, past the checks of the
//! SDK.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use clap::Parser;
use rustix::process::Signal;
use rusty_clients::dead_reckoning::DeadReckoning;
use rusty_contract::answer::Message;
use rusty_contract::{Answer, Estimate, Exit, JoinRequest, Phase, Reply, RunName};
use rusty_geometry::{SE2, Twist};
use rusty_link::{BorrowedFrame, ClientLink, Incoming, LinkError, Peer, WaitPolicy, monotonic_ns};

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
    /// pause (sleeps once, for sleep-us), exit, abort, panic, hang, leave, wrong-layout,
    /// wrong-protocol, wrong-pid, covariance, linger, flood (with answers that
    /// unasked), forge (answers for all others), fickle-and-mortal
    /// (says something else in every life, and exits in its first); mayfly
    /// (exits at the third tick that is new to it, in every life);
    /// wrong-name, silent-refusal, any-run (answers frames of other runs),
    /// integrates (a frame shown twice counts twice), chance, skew (a lopsided
    /// covariance), bad-code (ends with 5), last-word (answers it),
    /// orphan (goes on without a server), needs-map (panics without);
    /// kill-holding, kill-answered, kill-released,
    /// kill-last, kill-leave (SIGKILL: before the answer, after it, with the frame given
    /// back, before and after the leave message), kill-joining (SIGKILL sleep-us after it began to
    /// join), stop-holding, stop-answered (SIGSTOP once)
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
    #[arg(long)]
    launcher: Option<u32>,
}

fn main() -> Exit {
    let cli = Cli::parse();
    std::thread::sleep(Duration::from_millis(cli.late_ms));
    let stop = Arc::new(AtomicBool::new(false));
    let _ = signal_hook::flag::register(signal_hook::consts::SIGTERM, Arc::clone(&stop));
    let mut request = JoinRequest::new(&cli.name, std::process::id(), cli.wait.awake_ns(), "probe");
    match cli.mode.as_str() {
        "wrong-layout" => request.layout ^= 1,
        "wrong-protocol" => request.protocol += 1,
        "wrong-pid" => request.pid = std::os::unix::process::parent_id(),
        "wrong-name" => request.name.push('x'),
        _ => {}
    }
    if cli.mode == "kill-joining" {
        let after = Duration::from_micros(cli.sleep_us);
        std::thread::spawn(move || {
            std::thread::sleep(after);
            signal_self(Signal::KILL);
        });
    }
    let launcher = cli.launcher.map(Peer::new);
    let timeout = Duration::from_secs(20);
    let told = rusty_tests::credentials(cli.key_stdin);
    let joined = ClientLink::join_launched(
        &cli.run,
        launcher.as_ref(),
        told,
        &request,
        cli.wait,
        timeout,
        &stop,
    );
    match joined.and_then(|mut link| take_part(&cli, &mut link, &stop)) {
        Ok(()) if cli.mode == "bad-code" => std::process::exit(5),
        Ok(()) => Exit::Done,
        Err(LinkError::Refused(_)) if cli.mode == "silent-refusal" => Exit::Done,
        Err(e) => {
            eprintln!("probe: {e}");
            if matches!(e, LinkError::Dropped { .. }) { Exit::Lost } else { Exit::Failed }
        }
    }
}

fn take_part(cli: &Cli, link: &mut ClientLink, stop: &AtomicBool) -> Result<(), LinkError> {
    let start = link.start().clone();
    let mut odometry = DeadReckoning::of_start(&start);
    assert!(cli.mode != "needs-map" || start.map.is_some(), "no map");
    let mut integral = start.initial_pose.unwrap_or_default();
    let mut dice = 0x1234_5678_9ABC_DEF0u64;
    loop {
        let frame = match link.wait_frame(Duration::from_millis(500), stop) {
            Ok(Incoming::Frame(frame)) => frame,
            Ok(Incoming::Nothing) => continue,
            Err(LinkError::ServerGone { .. }) if cli.mode == "orphan" => {
                std::thread::sleep(Duration::from_secs(600));
                continue;
            }
            Err(LinkError::Stopped) => {
                link.send_raw(Answer::carrying(&Message::Leave))?;
                return Err(LinkError::Stopped);
            }
            Err(e) => return Err(e),
        };
        if frame.run_id != start.run_id && cli.mode != "any-run" {
            continue;
        }
        if frame.phase() != Phase::Tick {
            return leave(cli, link, &frame);
        }
        let pose = odometry.advance(frame.encoders());
        let step_m = frame.command().v_m_s * start.dt_s;
        integral = SE2::new(integral.x() + step_m, integral.y(), integral.theta());
        let mut reply = Reply::from(pose);
        match cli.mode.as_str() {
            "integrates" => reply = integral.into(),
            "fickle-and-mortal" => reply = SE2::new(std::process::id().into(), 0.0, 0.0).into(),
            "chance" => reply = SE2::new(monotonic_ns() as f64, 0.0, 0.0).into(),
            _ => {}
        }
        if cli.mode == "slow" {
            dice ^= dice << 13;
            dice ^= dice >> 7;
            dice ^= dice << 17;
            std::thread::sleep(Duration::from_micros(dice % cli.sleep_us));
        }
        if cli.mode == "covariance" || cli.mode == "skew" {
            let skew = if cli.mode == "skew" { 0.005 } else { 0.0 };
            let covariance = Some([0.01, skew, 0.0, 0.0, 0.02, 0.0, 0.0, 0.0, 0.03]);
            reply = Estimate { covariance, ..pose.into() }.into();
        }
        if frame.tick() < cli.at {
            link.answer(&frame, &Message::Reply(reply), false)?;
        } else if cli.mode == "leave" {
            return link.send_raw(Answer::carrying(&Message::Leave));
        } else {
            misbehave(cli, link, &frame, reply)?;
            drop(frame);
            if cli.mode == "kill-released" {
                signal_self(Signal::KILL);
            }
        }
    }
}

fn leave(cli: &Cli, link: &mut ClientLink, frame: &BorrowedFrame) -> Result<(), LinkError> {
    match cli.mode.as_str() {
        "last-word" => link.answer(frame, &Message::Reply(Reply::Abstain), false)?,
        "linger" => std::thread::sleep(Duration::from_secs(600)),
        "kill-last" => signal_self(Signal::KILL),
        _ => {}
    }
    link.send_raw(Answer::carrying(&Message::Leave))?;
    if cli.mode == "kill-leave" {
        signal_self(Signal::KILL);
    }
    Ok(())
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
        "kill-holding" => signal_self(Signal::KILL),
        "stop-holding" if frame.tick() == cli.at => signal_self(Signal::STOP),
        "exit" => std::process::exit(7),
        "mayfly" => {
            let seen = link.start().catch_up.as_ref().map_or(0, |c| c.ticks);
            if frame.tick() >= seen + 2 {
                std::process::exit(7);
            }
        }
        "fickle-and-mortal" if link.start().catch_up.is_none() => std::process::exit(7),
        "abort" => std::process::abort(),
        "panic" => panic!("on request"),
        "hang" => std::thread::sleep(Duration::from_secs(600)),
        _ => {}
    }
    if matches!(cli.mode.as_str(), "future-tick" | "old-tick" | "wrong-digest") {
        link.send_raw(raw)
    } else {
        link.answer(frame, &Message::Reply(reply), false)?;
        match cli.mode.as_str() {
            "kill-answered" => signal_self(Signal::KILL),
            "stop-answered" if frame.tick() == cli.at => signal_self(Signal::STOP),
            _ => {}
        }
        Ok(())
    }
}

/// Says for everyone but itself all that could end their part.
fn forge(link: &mut ClientLink, frame: &BorrowedFrame) -> Result<(), LinkError> {
    let (own, run_id) = (link.start().participant, link.start().run_id);
    for message in [Message::Failed, Message::Leave, Message::Reply(Reply::Abstain)] {
        for participant in (0..8).filter(|slot| *slot != own) {
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

/// SIGKILL and SIGSTOP leave no time for a further step.
fn signal_self(signal: Signal) {
    rusty_tests::send_signal(std::process::id(), signal);
}
