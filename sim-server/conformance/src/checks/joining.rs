//! Before the first frame: asking, being told, being refused.

use rusty_contract::layout::layout_hash;
use rusty_contract::scenario::Access;
use rusty_contract::{PROTOCOL_VERSION, Phase, Refusal};

use super::CheckResult;
use crate::fault::{Fault, Halt};
use crate::player::Player;
use crate::setting::Setting;
use crate::verdict::Verdict;
use crate::{Bench, Kit};

/// What a refused client should repeat.
const REASON: &str = "the conformance kit refuses everybody once";

pub(crate) fn joins(bench: &Bench<'_>) -> CheckResult {
    let kit = bench.kit;
    let folder = kit.folder()?;
    let mut player = Player::open(kit, &Setting::usual(kit.role), folder.path())?;
    let (call, request) = player.asked()?;
    let mut wrong = Vec::new();
    if request.protocol != PROTOCOL_VERSION {
        wrong.push(format!("protocol {}, known is {PROTOCOL_VERSION}", request.protocol));
    }
    if request.layout != layout_hash() {
        let known = layout_hash();
        wrong.push(format!("layout {:016x}, known is {known:016x}", request.layout));
    }
    if request.name != kit.name {
        wrong.push(format!("name {:?}, told was {:?}", request.name, kit.name));
    }
    if !player.client.is_of_group(request.pid) {
        let started = player.client.pid();
        wrong.push(format!(
            "process {}, which is neither the one started ({started}) nor of its group",
            request.pid
        ));
    }
    if !wrong.is_empty() {
        return Ok(Verdict::Fail(wrong.join("; ")));
    }
    let seen = format!("{:?}, protocol {}", request.client, request.protocol);
    player.admit(call, request)?;
    player.until_ready()?;
    player.end(Phase::Done)?;
    Ok(Verdict::Pass(seen))
}

pub(crate) fn ready_first(bench: &Bench<'_>) -> CheckResult {
    let kit = bench.kit;
    let folder = kit.folder()?;
    let mut player = Player::open(kit, &Setting::usual(kit.role), folder.path())?;
    player.gather()?;
    if let Some(early) = player.said.strays.first() {
        return Ok(Verdict::Fail(format!("before Ready: {:?}", early.message)));
    }
    player.end(Phase::Done)?;
    Ok(Verdict::Pass("Ready, first".to_owned()))
}

pub(crate) fn refused(bench: &Bench<'_>) -> CheckResult {
    let kit = bench.kit;
    let folder = kit.folder()?;
    let mut player = Player::open(kit, &Setting::usual(kit.role), folder.path())?;
    let (call, _) = player.asked()?;
    player.refuse(call, Refusal::Dropped { name: kit.name.clone(), why: REASON.to_owned() })?;
    player.until_ended()?;
    let client = &player.client;
    let end = client.end();
    Ok(match client.code() {
        None => Verdict::Fail(end),
        Some(0) => Verdict::Fail(format!("{end}; a client that may not take part failed")),
        Some(_) if client.crashed() => Verdict::Fail(format!("it crashed: {end}")),
        Some(_) if !client.words().contains(REASON) => {
            Verdict::Fail(format!("{end}; the reason given was {REASON:?}"))
        }
        Some(_) => Verdict::Pass(end),
    })
}

pub(crate) fn hidden_map(bench: &Bench<'_>) -> CheckResult {
    let setting = Setting { map: Access::Hidden, ..Setting::usual(bench.kit.role) };
    hidden(bench.kit, &setting)
}

pub(crate) fn hidden_pose(bench: &Bench<'_>) -> CheckResult {
    let setting = Setting { initial_pose: Access::Hidden, ..Setting::usual(bench.kit.role) };
    hidden(bench.kit, &setting)
}

fn hidden(kit: &Kit, setting: &Setting) -> CheckResult {
    let folder = kit.folder()?;
    let mut player = Player::open(kit, setting, folder.path())?;
    let played = player.gather().and_then(|()| player.ticks(12));
    let fault = match played.and_then(|()| player.end(Phase::Done)) {
        Ok(()) => return Ok(Verdict::Pass("it took part to the end".to_owned())),
        Err(Halt::Client(
            fault @ (Fault::Ended { .. } | Fault::GaveUp { .. } | Fault::Left(_)),
        )) => fault.to_string(),
        Err(halt) => return Err(halt),
    };
    // Said first, ended next.
    player.until_ended()?;
    let client = &player.client;
    let spoke = !client.words().trim().is_empty();
    let decided = spoke && client.code().is_some_and(|code| code != 0) && !client.crashed();
    Ok(if decided { Verdict::Pass(fault) } else { Verdict::Fail(fault) })
}
