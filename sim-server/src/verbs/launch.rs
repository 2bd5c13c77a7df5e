//! `launch`: server and participants as processes, from one command.

use rusty_contract::log::Source;
use rusty_contract::suggest::did_you_mean;
use rusty_contract::{LogHeader, Scenario, errln};

use super::Verbed;
use super::session::{RunPlace, RunSession, Starting};
use crate::cli::{LaunchArgs, RunArgs, ScenarioArgs};
use crate::error::VerbError;
use rusty_engine::scenario_file;
use rusty_engine::source::Simulated;

/// Runs a scenario with its participants.
///
/// # Errors
/// [`VerbError`] before the run; losses in the run are an exit code.
pub fn launch(args: &LaunchArgs) -> Verbed {
    simulate(&args.scenario, &args.run, Starting::Launch)
}

/// What `launch` and `serve` share.
pub(super) fn simulate(which: &ScenarioArgs, run: &RunArgs, starting: Starting) -> Verbed {
    let mut loaded = scenario_file::load(&which.scenario, &which.changes)?;
    let scenario = &mut loaded.scenario;
    scenario.seed = which.seed.unwrap_or(scenario.seed);
    scenario.ticks = which.ticks.unwrap_or(scenario.ticks);
    change_roster(&mut scenario.participants, run)?;
    scenario.check().map_err(|error| scenario_file::SetupError::Scenario {
        path: which.scenario.clone(),
        error,
    })?;
    let config = loaded.config()?;
    let scenario = &loaded.scenario;
    let place = RunPlace::find(run, &config.scenario, None)?;
    let header = LogHeader {
        writer: writer(),
        source: Source::Simulated,
        config,
        roster: scenario.participants.clone(),
        on_loss: scenario.on_loss,
    };
    let late = header.config.kidnappings.iter().find(|k| k.tick >= header.config.ticks);
    if let Some(late) = late {
        let (tick, ticks) = (late.tick, header.config.ticks);
        errln!("the run has {ticks} ticks: a kidnapping at tick {tick} will not happen");
    }
    let mut source = Simulated::new(header)?;
    RunSession {
        args: run,
        starting,
        answer_timeout_s: scenario.answer_timeout_s,
        join_timeout_s: scenario.join_timeout_s,
        announced: true,
    }
    .run(place, &mut source)
}

/// Applies `--add`, `--without` and `--sandbox`.
pub(super) fn change_roster(
    roster: &mut Vec<rusty_contract::Participant>,
    run: &RunArgs,
) -> Result<(), VerbError> {
    for name in &run.without {
        let before = roster.len();
        roster.retain(|p| p.name != *name);
        if roster.len() == before {
            let names: Vec<&str> = roster.iter().map(|p| p.name.as_str()).collect();
            let hint = did_you_mean(name, names.iter().copied());
            let remedy = format!("use one of: {}{hint}", names.join(", "));
            let error = rusty_contract::FieldError::new("--without", name, "is not there", remedy);
            return Err(error.into());
        }
    }
    run.add.iter().for_each(|text| scenario_file::add_estimator(roster, text));
    for participant in roster.iter_mut().filter(|p| !p.role.holds_key()) {
        participant.sandbox = run.sandbox.unwrap_or(participant.sandbox);
    }
    Scenario::check_roster(roster).map_err(|error| {
        let path = "participants".to_owned();
        scenario_file::SetupError::Scenario { path, error }.into()
    })
}

/// What a log says of its writer.
pub(super) fn writer() -> String {
    concat!("sim-server ", env!("CARGO_PKG_VERSION")).to_owned()
}
