//! How a run ends for a client.

use rustix::process::Signal;
use rusty_contract::Phase;

use super::CheckResult;
use crate::Bench;
use crate::dying::DyingServer;
use crate::fault::Halt;
use crate::player::Player;
use crate::setting::{Setting, TICKS};
use crate::verdict::Verdict;

pub(crate) fn done(bench: &Bench<'_>) -> CheckResult {
    let kit = bench.kit;
    let folder = kit.folder()?;
    let mut player = Player::open(kit, &Setting::usual(kit.role), folder.path())?;
    player.gather()?;
    player.ticks(TICKS)?;
    player.end(Phase::Done)?;
    let client = &player.client;
    Ok(match client.code() {
        Some(0) => Verdict::Pass("leave message, exit code 0".to_owned()),
        _ => Verdict::Fail(format!("leave message, then {}", client.end())),
    })
}

pub(crate) fn early(bench: &Bench<'_>) -> CheckResult {
    let kit = bench.kit;
    let mut seen = Vec::new();
    let endings = [
        ("interrupted", Phase::Interrupted, false),
        ("aborted", Phase::Aborted, false),
        ("aborted in mid-tick", Phase::Aborted, true),
    ];
    for (how, phase, in_mid_tick) in endings {
        let folder = kit.folder()?;
        let mut player = Player::open(kit, &Setting::usual(kit.role), folder.path())?;
        player.gather()?;
        player.ticks(5)?;
        if in_mid_tick {
            player.make();
            player.show()?;
        }
        match player.end(phase) {
            Err(Halt::Client(fault)) => return Ok(Verdict::Fail(format!("{how}: {fault}"))),
            ended => ended?,
        }
        if player.answered_end_of_run() {
            return Ok(Verdict::Fail(format!("{how}: it answered the end of run")));
        }
        let client = &player.client;
        match client.code() {
            Some(code @ (0 | 3)) => seen.push(format!("{how}: exit code {code}")),
            _ => return Ok(Verdict::Fail(format!("{how}: {}", client.end()))),
        }
    }
    Ok(Verdict::Pass(seen.join(", ")))
}

pub(crate) fn sigterm(bench: &Bench<'_>) -> CheckResult {
    let kit = bench.kit;
    let folder = kit.folder()?;
    let mut player = Player::open(kit, &Setting::usual(kit.role), folder.path())?;
    player.gather()?;
    player.ticks(5)?;
    player.signal(Signal::TERM);
    player.until_leave()?;
    player.until_ended()?;
    let client = &player.client;
    Ok(match client.code() {
        Some(_) if !client.crashed() => {
            Verdict::Pass(format!("leave message, then {}", client.end()))
        }
        _ => Verdict::Fail(format!("leave message, then {}", client.end())),
    })
}

pub(crate) fn dying_server(bench: &Bench<'_>) -> CheckResult {
    let folder = bench.kit.folder()?;
    let mut server = DyingServer::start(bench.kit, folder.path())?;
    server.until_played()?;
    server.kill();
    let left = server.until_client_ended()?;
    let client = server.client();
    let end = client.end();
    Ok(match client.code() {
        None => Verdict::Fail(end),
        Some(_) if client.crashed() => Verdict::Fail(format!("it crashed: {end}")),
        Some(0) => Verdict::Fail(format!("{end}; a run that broke off is no success")),
        Some(_) if client.words().trim().is_empty() => Verdict::Fail(end),
        Some(_) if !left.is_empty() => {
            let first = left[0].display();
            let count = left.len();
            Verdict::Fail(format!("{end}; it left {count} files of the run behind, first {first}"))
        }
        Some(_) => Verdict::Pass(end),
    })
}
