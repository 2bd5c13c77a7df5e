//! The scenario of a log, with the commands of its driver as a script: the run again,
//! without the person or program that drove.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use rusty_contract::config::MAX_COMMANDS;
use rusty_contract::log::Source;
use rusty_contract::output::make_folder;
use rusty_contract::scenario::Robots;
use rusty_contract::{LogHeader, Role, Scenario, ScriptConfig};
use rusty_geometry::Twist;
use rusty_geometry::places::{PLACES, place};
use serde::Serialize;

use super::error::ExportError;
use super::sheet::Sheet;
use super::walk::{Walk, Walked};

/// Names of the files.
const SCENARIO: &str = "scenario.toml";
const COMMANDS: &str = "commands.txt";
const WORLD: &str = "world.toml";

/// A scenario that was written.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ExportedScenario {
    /// The log.
    pub log: String,
    /// Where its ticks ended.
    #[serde(flatten)]
    pub walked: Walked,
    /// The files, the scenario first.
    pub files: Vec<String>,
    /// The seed.
    pub seed: u64,
    /// The drivers whose commands are the script now; they take part no more.
    pub drivers: Vec<String>,
}

/// Writes the scenario of `log` to `folder`, which is made if need be: the same world,
/// robot, seed and participants. The commands of a driver become a list. Every frame of
/// its run has the bits of the log.
///
/// # Errors
/// [`ExportError`]; no scenario is written then.
pub fn export(
    log: &Path,
    folder: &Path,
    force: bool,
    stop: &AtomicBool,
) -> Result<ExportedScenario, ExportError> {
    let mut walk = Walk::open(log, stop)?;
    let header = walk.header.clone();
    let refused = |problem: &str| {
        Err(ExportError::NoScenario { log: log.display().to_string(), problem: problem.to_owned() })
    };
    match (&header.source, &header.config.fleet) {
        (Source::Simulated, None) => {}
        (Source::Simulated, Some(_)) => return refused("its robot shared a world with others"),
        (Source::Forked { .. }, _) => return refused("its run changed in the middle"),
        (Source::Recorded { .. } | Source::Blind { .. }, _) => {
            return refused("it is not of a simulation whose truth is known");
        }
    }
    let is_driven = header.config.script.is_driver();
    // In tick 0 a driven robot stands; the answer to tick t moves it in tick t + 1.
    let mut commands = vec![Twist::default()];
    while walk.tick()?.is_some() {
        commands.push(walk.command());
    }
    if walk.walked.ticks == 0 {
        return refused("it has no complete tick");
    }
    commands.truncate(usize::try_from(walk.walked.ticks).unwrap_or(usize::MAX));
    if is_driven && commands.len() > MAX_COMMANDS {
        return refused("its drive is longer than a list of commands can be");
    }
    let drivers = header.roster.iter().filter(|p| is_driven && p.role == Role::Driver);
    let drivers = drivers.map(|p| p.name.clone()).collect();
    make_folder(folder).map_err(ExportError::io(folder))?;
    let sheet = |name: &str| Sheet::create(&folder.join(name), force);
    // All of them before the first is put in its place.
    let mut files = vec![(SCENARIO, sheet(SCENARIO)?)];
    let scenario = scenario(&header, walk.walked.ticks, is_driven);
    files[0].1.head(format_args!("{}", text(&scenario)?))?;
    if is_driven {
        let mut list = sheet(COMMANDS)?;
        write_commands(&mut list, &commands)?;
        files.push((COMMANDS, list));
    }
    if scenario.world_file.is_some() {
        let mut world = sheet(WORLD)?;
        let toml = header.config.world.to_toml();
        let toml = toml.map_err(|e| ExportError::Toml(e.to_string()))?;
        world.head(format_args!("{toml}"))?;
        files.push((WORLD, world));
    }
    // The scenario last: where it is, all is.
    let written = files.into_iter().rev().map(|(_, sheet)| sheet.finish());
    let mut written = written.collect::<Result<Vec<String>, _>>()?;
    written.reverse();
    Ok(ExportedScenario {
        log: log.display().to_string(),
        walked: walk.walked.clone(),
        files: written,
        seed: header.config.seed,
        drivers,
    })
}

fn scenario(header: &LogHeader, ticks: u64, is_driven: bool) -> Scenario {
    let config = header.config.clone();
    let is_it = |name: &&str| place(name).is_some_and(|place| *place.spec() == config.world);
    let world = PLACES.iter().map(|(name, _)| *name).find(is_it);
    let script = match is_driven {
        true => ScriptConfig::Commands { file: Some(COMMANDS.to_owned()), list: Vec::new() },
        false => config.script,
    };
    let takes_part = |p: &&rusty_contract::Participant| !is_driven || p.role != Role::Driver;
    let usual = Scenario::default();
    Scenario {
        name: config.scenario,
        seed: config.seed,
        ticks,
        dt_s: config.dt_s,
        scan_every: config.scan_every,
        world: world.map_or(usual.world, str::to_owned),
        world_file: world.is_none().then(|| WORLD.to_owned()),
        start: config.start,
        on_loss: header.on_loss,
        robot: Robots::One(config.robot),
        lidar: config.lidar,
        sensors: config.sensors,
        script,
        kidnappings: config.kidnappings,
        walkers: config.walkers,
        crowd: config.crowd,
        events: config.events,
        patches: config.patches,
        participants: header.roster.iter().filter(takes_part).cloned().collect(),
        ..usual
    }
}

fn text(scenario: &Scenario) -> Result<String, ExportError> {
    toml::to_string(scenario).map_err(|e| ExportError::Toml(e.to_string()))
}

/// A line for each command with the number of ticks for which it holds.
fn write_commands(list: &mut Sheet, commands: &[Twist]) -> Result<(), ExportError> {
    list.head(format_args!("# v_m_s omega_rad_s ticks"))?;
    let bits = |twist: &Twist| [twist.v_m_s.to_bits(), twist.omega_rad_s.to_bits()];
    for same in commands.chunk_by(|a, b| bits(a) == bits(b)) {
        let Twist { v_m_s, omega_rad_s } = same[0];
        list.line(format_args!("{v_m_s:?} {omega_rad_s:?} {}", same.len()))?;
    }
    Ok(())
}
