//! `launch` and `serve`: run a scenario, with participants that the server starts or
//! that are started by hand.

use anyhow::Result;
use clap::Args;
use rusty_contract::config::Event;
use rusty_contract::{Exit, LogHeader, RunConfig, errln};
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
    headers.iter().for_each(warn_of_no_effect);
    let robots = scenario.robot.entries();
    if robots.is_empty() {
        let place = RunPlace::find(run, &scenario.name, None)?;
        return session.run(place, &mut Simulated::new(headers.swap_remove(0))?);
    }
    let names: Vec<&str> = robots.iter().map(|robot| robot.name.as_str()).collect();
    let places = RunPlace::find_each(run, &scenario.name, &names)?;
    session.run_together(places, &mut Simulated::together(headers)?)
}

/// Warns of what the scenario plans and the run will not have.
fn warn_of_no_effect(header: &LogHeader) {
    let RunConfig { ticks, kidnappings, events, .. } = &header.config;
    let planned = kidnappings.iter().map(|k| ("a kidnapping", k.tick));
    for (what, tick) in planned.chain(events.iter().map(|event| ("an event", event.tick()))) {
        if tick >= *ticks {
            errln!("the run has {ticks} ticks: {what} at tick {tick} will not happen");
        }
    }
    let is_put = |wanted: u8, until: u64| {
        events.iter().any(|event| match *event {
            Event::PutBox { tick, number, .. } => number == wanted && tick <= until,
            _ => false,
        })
    };
    for event in events {
        if let Event::RemoveBox { tick, number } = *event
            && !is_put(number, tick)
        {
            errln!("event at tick {tick}: there is no box {number} to remove then");
        }
    }
    warn_of_outside(&header.config);
}

/// Warns of people, boxes and patches that lie outside the world, where nothing meets them.
fn warn_of_outside(config: &RunConfig) {
    let [x_min, y_min, x_max, y_max] = config.world.bounds;
    let tell = |what: String, points: &[[f64; 2]]| {
        let all = |is_out: &dyn Fn(&[f64; 2]) -> bool| points.iter().all(is_out);
        let outside = all(&|p| p[0] < x_min)
            || all(&|p| p[0] > x_max)
            || all(&|p| p[1] < y_min)
            || all(&|p| p[1] > y_max);
        if outside {
            errln!(
                "{what} lies outside the world: x is {x_min} to {x_max} m there, y {y_min} to \
                 {y_max} m"
            );
        }
    };
    for (i, walker) in config.walkers.iter().enumerate() {
        for (k, point) in walker.waypoints.iter().enumerate() {
            tell(format!("walker[{i}].waypoints[{k}] = {point:?}"), &[*point]);
        }
    }
    for event in &config.events {
        if let Event::PutBox { number, at, .. } = event {
            let at = [at.x(), at.y()];
            tell(format!("box {number} at {at:?}"), &[at]);
        }
    }
    for (i, patch) in config.patches.iter().enumerate() {
        tell(format!("patch[{i}]"), &patch.corners);
    }
}
