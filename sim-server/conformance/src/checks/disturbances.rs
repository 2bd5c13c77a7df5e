//! Frames that are not as they should be: late, twice, of others, damaged.

use std::time::{Duration, Instant};

use rustix::process::Signal;
use rusty_contract::Phase;
use rusty_link::{Peer, PeerState};

use super::{CheckResult, disturbed};
use crate::Bench;
use crate::fault::{Fault, Halt};
use crate::player::Player;
use crate::setting::Setting;
use crate::spoilt;
use crate::verdict::Verdict;

/// How long a late frame is late at least and at most.
const LATE: [Duration; 2] = [Duration::from_millis(30), Duration::from_millis(200)];
/// How long a stopped client is left alone with a frame.
const STOPPED: Duration = Duration::from_millis(50);

pub(crate) fn late(bench: &Bench<'_>) -> CheckResult {
    let (_, verdict) = disturbed(bench, |player, tick| {
        if tick % 6 != 3 {
            return player.tick();
        }
        let awake = Duration::from_nanos(player.client_awake_ns());
        player.rest(awake.saturating_mul(2).clamp(LATE[0], LATE[1]))?;
        player.make();
        player.show()?;
        // In the second half no process wakes it.
        if tick < 12 {
            player.wake();
        }
        player.answered()?;
        player.close()
    })?;
    Ok(verdict)
}

pub(crate) fn doubled(bench: &Bench<'_>) -> CheckResult {
    let (said, verdict) = disturbed(bench, |player, tick| {
        player.make();
        player.show()?;
        // Before the answer, after it, after the end of the tick.
        if tick == 5 {
            player.show()?;
        }
        player.wake();
        player.answered()?;
        if tick == 7 {
            player.show()?;
            player.wake();
        }
        player.close()?;
        if tick == 15 {
            player.show()?;
            player.wake();
        }
        Ok(())
    })?;
    let again = said.strays.len();
    Ok(match verdict {
        Verdict::Pass(seen) if again > 0 => {
            Verdict::Pass(format!("{seen}; {again} second answers, which do no harm"))
        }
        verdict => verdict,
    })
}

pub(crate) fn foreign(bench: &Bench<'_>) -> CheckResult {
    let mut foreign_digests = Vec::new();
    let (said, verdict) = disturbed(bench, |player, tick| {
        if tick != 4 && tick != 10 {
            return player.tick();
        }
        player.make();
        let foreign = player.foreign();
        foreign_digests.push(foreign.digest());
        player.show_other(&foreign)?;
        player.show()?;
        player.wake();
        player.answered()?;
        player.close()
    })?;
    let mut all = said.answers.iter().chain(&said.strays);
    Ok(match all.find(|h| foreign_digests.contains(&h.answer.digest_seen)) {
        Some(received) => {
            let tick = received.asked.0;
            Verdict::Fail(format!("at tick {tick} it answered the frame of another run"))
        }
        None => verdict,
    })
}

pub(crate) fn stopped(bench: &Bench<'_>) -> CheckResult {
    let (_, verdict) = disturbed(bench, |player, tick| {
        if tick != 6 {
            return player.tick();
        }
        player.make();
        player.signal(Signal::STOP);
        until_stopped(player, bench.kit.patience)?;
        player.show()?;
        player.wake();
        player.rest(STOPPED)?;
        player.signal(Signal::CONT);
        player.answered()?;
        player.close()
    })?;
    Ok(verdict)
}

/// Waits until the kernel says that the client stands still.
fn until_stopped(player: &Player<'_>, patience: Duration) -> Result<(), Halt> {
    let peer = Peer::new(player.joined_pid());
    let until = Instant::now() + patience;
    // A client that cannot be stopped is slow in no way: the check goes on.
    while peer.state() == PeerState::Running && Instant::now() < until {
        player.rest(Duration::from_millis(1))?;
    }
    Ok(())
}

pub(crate) fn damaged(bench: &Bench<'_>) -> CheckResult {
    let kit = bench.kit;
    let folder = kit.folder()?;
    let mut player = Player::open(kit, &Setting::usual(kit.role), folder.path())?;
    player.gather()?;
    player.ticks(5)?;
    let after = (|| {
        player.make();
        let damaged = spoilt::damaged(&player.frame);
        player.show_other(&damaged)?;
        player.wake();
        player.answered()?;
        player.close()?;
        player.ticks(5)?;
        player.end(Phase::Done)
    })();
    let client = &player.client;
    Ok(match after {
        Ok(()) if client.code() == Some(0) => {
            Verdict::Fail("it took the frame and ended with exit code 0".to_owned())
        }
        Ok(()) => Verdict::Pass(client.end()),
        Err(Halt::Client(fault)) if client.crashed() => {
            Verdict::Fail(format!("it crashed: {fault}"))
        }
        Err(Halt::Client(fault @ (Fault::GaveUp { .. } | Fault::Ended { .. }))) => {
            Verdict::Pass(fault.to_string())
        }
        Err(halt) => return Err(halt),
    })
}
