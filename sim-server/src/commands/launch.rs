//! `launch` and `serve`: run a scenario, with participants that the server starts or
//! that are started by hand.

use anyhow::{Result, bail};
use clap::Args;
use rusty_contract::{Exit, FieldError, LogHeader, errln};
use rusty_engine::remarks::remarks;
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
    if let (Starting::ByHand, Some(text)) = (starting, run.add.iter().find(|a| a.contains('='))) {
        let remedy = "give the name only and start it with --run, or use launch";
        let problem = "has a command, and serve starts no participant";
        bail!(FieldError::new("--add", text, problem, remedy));
    }
    let given =
        [("seed", "--seed", which.seed.is_some()), ("ticks", "--ticks", which.ticks.is_some())];
    scenario_file::check_options(&which.changes, &given)?;
    let mut loaded = scenario_file::load_unchecked(&which.scenario, &which.changes)?;
    let scenario = &mut loaded.scenario;
    scenario.seed = which.seed.unwrap_or(scenario.seed);
    scenario.ticks = which.ticks.unwrap_or(scenario.ticks);
    run.change_roster(&mut scenario.participants)?;
    scenario
        .check()
        .map_err(|error| SetupError::Scenario { path: which.scenario.clone(), error })?;
    let configs = loaded.configs_with(rusty_floorplan::read)?;
    let scenario = &loaded.scenario;
    let session = RunSession {
        args: run,
        starting,
        answer_timeout_s: scenario.answer_timeout_s,
        join_timeout_s: scenario.join_timeout_s,
        announced: true,
    };
    let header =
        |(place, config)| simulated_header(config, scenario.roster_of(place), scenario.on_loss);
    let mut headers: Vec<LogHeader> = configs.into_iter().enumerate().map(header).collect();
    headers
        .iter()
        .flat_map(|header| remarks(&header.config, &header.roster))
        .for_each(|remark| errln!("{remark}"));
    let robots = scenario.robot.entries();
    if robots.is_empty() {
        let place = RunPlace::find(run, &scenario.name, &[])?;
        return session.run(place, &mut Simulated::new(headers.swap_remove(0))?);
    }
    let names: Vec<&str> = robots.iter().map(|robot| robot.name.as_str()).collect();
    let places = RunPlace::find_each(run, &scenario.name, &names)?;
    session.run_together(places, &mut Simulated::together(headers)?)
}
