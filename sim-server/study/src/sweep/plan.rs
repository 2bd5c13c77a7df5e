//! What a sweep has to do: every seed in every cell, in one order.

use std::collections::BTreeSet;
use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;

use rusty_contract::{FieldError, Participant, Role, ScriptConfig};
use rusty_sim::Sim;

use super::cell::Cell;
use super::error::SweepError;
use super::grid::{Axis, combinations};
use super::seeds::Seeds;
use super::shard::Shard;
use rusty_engine::scenario_file::{self, SetupError};

/// The most cells.
const MOST_CELLS: usize = 10_000;
/// The most runs of a sweep: their rows are in memory together.
const MOST_RUNS: u64 = 4_000_000;
/// The most runs that are followed along their way.
const MOST_TRACKS: u64 = 20_000;
/// Samples along the way of one run.
pub(super) const SAMPLES: u64 = 60;

/// What was asked for.
#[derive(Clone, Debug)]
pub struct Request {
    /// A scenario file, or a built-in one.
    pub scenario: String,
    /// Which seeds.
    pub seeds: Seeds,
    /// What is swept, in order.
    pub axes: Vec<Axis>,
    /// Number of ticks, if not the scenario's.
    pub ticks: Option<u64>,
    /// Whether the scenario's clients take part, as processes.
    pub clients: bool,
    /// Estimators that take part in every run, as `launch --add` has them.
    pub add: Vec<String>,
}

/// The runs of a sweep. Run number r is that of cell r / seeds and of the seed
/// at place r % seeds.
pub struct Plan {
    /// What was asked for.
    pub request: Request,
    /// The settings.
    pub cells: Vec<Cell>,
    /// Who takes part in each cell; none where dead reckoning runs inside.
    pub rosters: Vec<Vec<Participant>>,
    /// The worlds of the cells before their first tick; none with clients.
    pub worlds: Vec<Sim>,
    /// The files that the settings are read from: the scenario, and those that it names.
    pub files: BTreeSet<PathBuf>,
    /// The runs that are made: all of them, or those of one shard.
    pub runs: Range<u64>,
    /// Whether participants of a new process must answer alike, too, in a repeated run.
    pub all_alike: bool,
}

impl Plan {
    /// Loads the scenario once per cell, and checks everything that can be
    /// checked before the first run.
    ///
    /// # Errors
    /// [`SweepError`] names option, field, value and remedy.
    pub fn new(request: Request) -> Result<Self, SweepError> {
        Self::of(request, None)
    }

    /// As [`new`](Self::new) with client processes, and with `roster` in place of the
    /// scenario's participants, who must all answer a repeated run alike. Of several robots the first has it, and the others must
    /// move by themselves.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn with_roster(request: Request, roster: &[Participant]) -> Result<Self, SweepError> {
        Self::of(Request { clients: true, ..request }, Some(roster))
    }

    fn of(request: Request, own: Option<&[Participant]>) -> Result<Self, SweepError> {
        check_axes(&request)?;
        let all = combinations(&request.axes, MOST_CELLS).ok_or_else(|| {
            let problem = format!("make more than {MOST_CELLS} combinations");
            FieldError::new("--set", "the lists", problem, "sweep fewer fields or values at once")
        })?;
        let (mut cells, mut rosters, mut worlds) = (Vec::new(), Vec::new(), Vec::new());
        let mut files = BTreeSet::from([PathBuf::from(&request.scenario)]);
        for parameters in all {
            let (cell, roster, named) = load(&request, parameters, own)?;
            files.extend(named);
            if request.clients {
                check_roster(&roster)?;
                rosters.push(roster);
            } else {
                check_script(&cell.config.script)?;
                worlds.push(Sim::new(cell.config.clone())?);
            }
            cells.push(cell);
        }
        let count = request.seeds.count().checked_mul(cells.len() as u64);
        match count {
            Some(count) if count <= MOST_RUNS => {
                let all_alike = own.is_some();
                Ok(Self { request, cells, rosters, worlds, files, runs: 0..count, all_alike })
            }
            _ => {
                let problem = format!("makes more than {MOST_RUNS} runs");
                let remedy = "sweep fewer seeds at once: the others go into another table";
                Err(FieldError::new("--seeds", request.seeds, problem, remedy).into())
            }
        }
    }

    /// Returns the plan of one shard.
    #[must_use]
    pub fn of_shard(self, shard: Shard) -> Self {
        let runs = shard.of(self.cells.len() as u64 * self.request.seeds.count());
        Self { runs, ..self }
    }

    /// Index of the cell of a run, and its seed.
    #[must_use]
    pub fn place(&self, run: u64) -> (usize, u64) {
        let seeds = &self.request.seeds;
        ((run / seeds.count()) as usize, seeds.at(run % seeds.count()))
    }

    /// Returns the number of runs that are made.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.runs.end - self.runs.start
    }

    /// Returns the number of rows of its table: one for each estimator of a run.
    #[must_use]
    pub fn rows(&self) -> u64 {
        let estimators = |cell: usize| match self.rosters.get(cell) {
            None => 1,
            Some(roster) => roster.iter().filter(|p| p.answers()).count() as u64,
        };
        let seeds = self.request.seeds.count();
        (0..self.cells.len()).map(|cell| seeds * estimators(cell)).sum()
    }

    /// Ticks of a run.
    #[must_use]
    pub fn ticks(&self, run: u64) -> u64 {
        self.cells[self.place(run).0].config.ticks
    }

    /// The ticks at which a run is sampled; none of a run that is not followed.
    /// All seeds of a cell have the same.
    #[must_use]
    pub fn sampling(&self, run: u64) -> Sampling {
        let followed = (MOST_TRACKS / self.cells.len() as u64).max(1);
        let is_followed = run % self.request.seeds.count() < followed;
        let ticks = self.ticks(run);
        Sampling { ticks, samples: if is_followed { SAMPLES.min(ticks) } else { 0 }, taken: 0 }
    }
}

/// The ticks at which a run is sampled: evenly spaced up to and with the last.
#[derive(Clone, Copy, Debug)]
pub struct Sampling {
    ticks: u64,
    samples: u64,
    taken: u64,
}

impl Sampling {
    /// How many there are.
    #[must_use]
    pub fn count(&self) -> usize {
        self.samples as usize
    }

    /// The next one; `u64::MAX` after the last.
    #[must_use]
    pub fn next_tick(&mut self) -> u64 {
        if self.taken == self.samples {
            return u64::MAX;
        }
        self.taken += 1;
        let end = u128::from(self.ticks) * u128::from(self.taken) / u128::from(self.samples);
        // At least one: there are no more samples than ticks.
        end as u64 - 1
    }
}

/// Refuses fields that another option, or another field, would set again.
fn check_axes(request: &Request) -> Result<(), FieldError> {
    let axes = &request.axes;
    for (i, axis) in axes.iter().enumerate() {
        let wrong =
            |problem: &str, remedy: &str| Err(FieldError::new("--set", &axis.key, problem, remedy));
        if axis.key == "seed" {
            return wrong("is swept by another option", "give --seeds A..B");
        }
        if axis.key == "ticks" && request.ticks.is_some() {
            return wrong("is set by --ticks as well", "leave out one of both");
        }
        if axes[..i].iter().any(|a| a.key == axis.key) {
            return wrong("is given twice", "give all its values in one list: key=v1,v2");
        }
        let is_part =
            |a: &str, b: &str| a.strip_prefix(b).is_some_and(|rest| rest.starts_with('.'));
        if axes.iter().any(|a| is_part(&a.key, &axis.key)) {
            return wrong("contains another field of --set", "give the fields in it one by one");
        }
    }
    Ok(())
}

/// The scenario with these parameters, by the code that `launch` uses.
fn load(
    request: &Request,
    parameters: Vec<(String, String)>,
    own: Option<&[Participant]>,
) -> Result<(Cell, Vec<Participant>, Vec<PathBuf>), SweepError> {
    let changes: Vec<String> = parameters.iter().map(|(k, v)| format!("{k}={v}")).collect();
    let mut loaded = match own {
        None => scenario_file::load(&request.scenario, &changes)?,
        Some(_) => scenario_file::load_unchecked(&request.scenario, &changes)?,
    };
    loaded.scenario.seed = request.seeds.at(0);
    loaded.scenario.ticks = request.ticks.unwrap_or(loaded.scenario.ticks);
    let roster = &mut loaded.scenario.participants;
    own.into_iter().for_each(|own| *roster = own.to_vec());
    for text in &request.add {
        scenario_file::add_estimator(roster, "--add", text)?;
    }
    loaded
        .scenario
        .check()
        .map_err(|error| SetupError::Scenario { path: request.scenario.clone(), error })?;
    let config = loaded.config_with(rusty_floorplan::read)?;
    if config.fleet.is_some() {
        // Of several robots the first is swept, and the others must move by themselves.
        Sim::new(config.clone())?;
        if request.clients && own.is_none() {
            let problem = "runs the clients of one robot, and the scenario has several";
            let remedy = "leave it out, or run `sim-server launch` for each seed";
            return Err(FieldError::new("--clients", &request.scenario, problem, remedy).into());
        }
    }
    let roster = loaded.scenario.roster_of(0);
    Ok((Cell { parameters: Arc::from(parameters), config }, roster, loaded.files()))
}

/// Inside, there is no driver.
fn check_script(script: &ScriptConfig) -> Result<(), FieldError> {
    if !script.is_driver() {
        return Ok(());
    }
    let remedy = "give --clients to have the scenario's driver take part, or another script";
    Err(FieldError::new("script.kind", "driver", "has nobody who drives inside a sweep", remedy))
}

/// With clients, the figures are the scorer's.
fn check_roster(roster: &[Participant]) -> Result<(), FieldError> {
    let wrong = |who: &str, problem: &str, remedy: &str| {
        Err(FieldError::new("--clients", who, problem, remedy))
    };
    if !roster.iter().any(|p| p.role == Role::Scorer) {
        let remedy = "add one: [[participant]] name = \"score\", role = \"scorer\"";
        return wrong("the scenario", "has no scorer, and its scores are the rows", remedy);
    }
    if let Some(p) = roster.iter().find(|p| p.is_awaited() && p.command.is_empty()) {
        let remedy = "say how it is started: its command in the scenario, or --add NAME=COMMAND";
        return wrong(&p.name, "has no command", remedy);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn request(seeds: &str, axes: &[&str]) -> Request {
        Request {
            scenario: "patrol".to_owned(),
            seeds: seeds.parse().unwrap(),
            axes: axes.iter().map(|text| Axis::parse("--set", text).unwrap()).collect(),
            ticks: None,
            clients: false,
            add: Vec::new(),
        }
    }

    #[test]
    fn runs_come_by_cell_and_then_by_seed() {
        let plan = Plan::new(request("7..10", &["ticks=100,31,1"])).unwrap();
        assert_eq!(plan.runs, 0..9);
        let places: Vec<_> = plan.runs.clone().map(|run| plan.place(run)).collect();
        assert_eq!(places[..4], [(0, 7), (0, 8), (0, 9), (1, 7)]);
        assert_eq!([0, 3, 8].map(|run| plan.ticks(run)), [100, 31, 1]);
    }

    #[test]
    fn a_field_is_set_in_one_place() {
        let refused = |request: Request| Plan::new(request).err().map(|e| e.to_string());
        let ticks = Request { ticks: Some(50), ..request("0..2", &["ticks=10,20"]) };
        assert!(refused(ticks).unwrap().contains("--set ticks"));
        let whole = "robot={ slip_std = 0.3 }";
        for axes in [["robot.slip_std=0.1,0.2", whole], [whole, "robot.slip_std=0.1,0.2"]] {
            assert!(refused(request("0..2", &axes)).unwrap().contains("--set robot:"));
        }
        assert_eq!(refused(request("0..2", &["robot.slip_std=0.1", "robot.track_m=0.2"])), None);
        assert!(Axis::parse("--set", "robot.slip_std=0.1,0.10").is_err());
    }

    #[test]
    fn samples_are_even_and_end_with_the_last_tick() {
        let plan = Plan::new(request("0..5", &["ticks=300,7,1"])).unwrap();
        let samples = |run| {
            let mut sampling = plan.sampling(run);
            (0..sampling.count()).map(|_| sampling.next_tick()).collect::<Vec<_>>()
        };
        let every_fifth: Vec<u64> = (1..=60).map(|k| 5 * k - 1).collect();
        assert_eq!(samples(4), every_fifth);
        assert_eq!(samples(5), [0, 1, 2, 3, 4, 5, 6]);
        assert_eq!(samples(14), [0]);
        assert_eq!(plan.sampling(14).taken, 0);
        // Of very many runs the first of each cell are followed.
        let many = Plan::new(request("0..30000", &["robot.slip_std=0.01,0.02"])).unwrap();
        let followed = many.runs.clone().filter(|run| many.sampling(*run).count() > 0);
        let followed: Vec<u64> = followed.collect();
        assert_eq!(followed.len(), 20_000);
        assert_eq!((followed[9_999], followed[10_000]), (9_999, 30_000));
    }
}
