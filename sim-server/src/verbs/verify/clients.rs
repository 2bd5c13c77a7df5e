//! The answers again: a log's estimators and driver, run on its frames.
//!
//! Real processes in lockstep, as in a replay; but who only looks on (scorers,
//! loggers, observers) stays away, and what the programs print goes into a
//! folder that is gone afterwards.

use std::path::Path;

use rusty_contract::{FieldError, Phase, RunName, Scenario};
use rusty_link::WaitPolicy;
use serde::Serialize;

use super::super::session::{Made, RunPlace, RunSession, Starting};
use crate::cli::RunArgs;
use crate::error::VerbError;
use rusty_engine::compare::Mismatch;
use rusty_engine::run::Pace;
use rusty_engine::source::{Compared, FrameSource as _, Recording};

/// What came of running the clients again.
#[derive(Debug, Default, Serialize)]
pub(super) struct Clients {
    /// Everyone who was run, in roster order.
    pub participants: Vec<Compared>,
    /// Ticks for which they were.
    pub ticks: u64,
    /// The first answer that is not the recorded one.
    #[serde(skip)]
    pub first_difference: Option<Mismatch>,
    /// The run did not come to its end.
    pub interrupted: bool,
    /// What else there is to say.
    #[serde(skip)]
    pub remarks: Vec<String>,
}

/// Runs everyone who answers in `log` on its frames again.
///
/// # Errors
/// [`VerbError`] names a participant whose program is not there or cannot take
/// part, and says so of one that was started by hand.
pub(super) fn run(log: &Path) -> Result<Clients, VerbError> {
    let (mut source, _) = Recording::open(log)?;
    let header = source.header_mut();
    header.roster.retain(|p| p.answers());
    // One that is lost again shows as a missing answer.
    header.on_loss = rusty_contract::OnLoss::Continue;
    if let Some(by_hand) = header.roster.iter().find(|p| p.command.is_empty()) {
        let problem = "is empty: it was started by hand, and the log does not say how";
        let remedy = "use `sim-server replay LOG --attach` and start it by hand again";
        let field = format!("participant {:?}, command", by_hand.name);
        return Err(FieldError::new(field, "[]", problem, remedy).into());
    }
    if header.roster.is_empty() || source.ticks() == 0 {
        let remarks = vec!["the log has no answers to compare".to_owned()];
        return Ok(Clients { remarks, ..Clients::default() });
    }
    let here = Path::new("a temporary folder");
    let folder = tempfile::tempdir().map_err(VerbError::io(here))?;
    let made = play(&mut source, folder.path())?;
    gather(&source, &made)
}

fn play(source: &mut Recording, folder: &Path) -> Result<Made, VerbError> {
    let random = getrandom::u32().map_err(VerbError::Random)?;
    let args = RunArgs {
        run: Some(RunName::new(&format!("verify-{random:08x}"))?),
        out: Some(folder.to_owned()),
        force: false,
        pace: Pace::Max,
        paused: false,
        sandbox: None,
        wait: WaitPolicy::default(),
        answer_timeout: None,
        join_timeout: None,
        add: Vec::new(),
        without: Vec::new(),
        json: false,
        quiet: true,
    };
    let place = RunPlace::find(&args, &source.header().config.scenario, None)?;
    let defaults = Scenario::default();
    RunSession {
        args: &args,
        starting: Starting::Launch,
        answer_timeout_s: defaults.answer_timeout_s,
        join_timeout_s: defaults.join_timeout_s,
        announced: false,
    }
    .make(place, source)
}

fn gather(source: &Recording, made: &Made) -> Result<Clients, VerbError> {
    let outcome = &made.outcome;
    if let Some(loss) = outcome.losses.iter().find(|l| l.tick.is_none()) {
        let (name, why) = (loss.name.clone(), loss.detail.clone());
        return Err(VerbError::NeverTookPart { name, why });
    }
    let mut clients = Clients {
        ticks: outcome.ticks,
        interrupted: outcome.phase == Phase::Interrupted || outcome.source_error.is_some(),
        ..Clients::default()
    };
    let remarks = &mut clients.remarks;
    remarks.extend(outcome.source_error.iter().map(ToString::to_string));
    for (seat, how) in &made.ended_badly {
        remarks.push(format!("{}: {how}", made.header.roster[*seat].name));
    }
    if clients.interrupted {
        remarks.push(format!("the answers were compared up to tick {}", outcome.ticks));
    }
    let Some(comparison) = source.comparison() else { return Ok(clients) };
    for p in comparison.participants.iter().filter(|p| p.unrecorded > 0) {
        remarks.push(format!(
            "{}: the log lacks its answers to {} ticks, because it had been lost",
            p.name, p.unrecorded
        ));
    }
    clients.participants.clone_from(&comparison.participants);
    clients.first_difference = comparison.first_difference.as_ref().map(|d| Mismatch {
        tick: d.tick,
        participant: Some(d.name.clone()),
        field: d.field.clone(),
        a: d.recorded.clone(),
        b: d.replayed.clone(),
    });
    Ok(clients)
}
