//! `launch` and `serve`: run a scenario, with participants that the server starts or
//! that are started by hand.

use anyhow::Result;
use clap::Args;
use rusty_contract::{Exit, errln};
use rusty_engine::scenario_file::{self, SetupError};
use rusty_engine::source::{Simulated, simulated_header};

use super::arguments::{RunArgs, ScenarioArgs};
use super::session::{RunPlace, RunSession, Starting};

#[derive(Args, Clone, Debug)]
pub struct LaunchArgs {
    #[command(flatten)]
    pub scenario: ScenarioArgs,
    #[command(flatten)]
    pub run: RunArgs,
}

pub fn launch(args: &LaunchArgs) -> Result<Exit> {
    simulate(args, Starting::Launch)
}

/// The key for scorers and loggers is in the run's folder (mode 0600) during the run.
pub fn serve(args: &LaunchArgs) -> Result<Exit> {
    simulate(args, Starting::ByHand)
}

fn simulate(args: &LaunchArgs, starting: Starting) -> Result<Exit> {
    let LaunchArgs { scenario: which, run } = args;
    let mut loaded = scenario_file::load_unchecked(&which.scenario, &which.changes)?;
    let scenario = &mut loaded.scenario;
    scenario.seed = which.seed.unwrap_or(scenario.seed);
    scenario.ticks = which.ticks.unwrap_or(scenario.ticks);
    run.change_roster(&mut scenario.participants)?;
    scenario
        .check()
        .map_err(|error| SetupError::Scenario { path: which.scenario.clone(), error })?;
    let config = loaded.config_with(rusty_floorplan::read)?;
    let scenario = &loaded.scenario;
    let place = RunPlace::find(run, &config.scenario, None)?;
    let header = simulated_header(config, scenario.participants.clone(), scenario.on_loss);
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
