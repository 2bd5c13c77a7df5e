//! `bench latency`: a tick of the protocol compared with the transport alone and the
//! machine alone.
//!
//! For each number of clients, beams and scans there are repetitions; each is a
//! run of the server with real client processes, the same with each tick made after the
//! answers to the one before it (*in order*), then the transport without a
//! protocol ([`rusty_link::raw`]), then the machine's floor
//! ([`rusty_link::floor`]), with as many processes that wait in the same way. So
//! whatever disturbs the machine meets all three, and the ratios are taken
//! within a repetition.

mod calls;
mod repeated;

use rusty_contract::{Participant, Role, RunConfig, RunName, errln};
use rusty_link::{Domain, WaitPolicy};

use super::noise::NoiseMeter;
use super::results::{Results, Row};
use super::stage::{Bare, Stage, estimators, mix};
use crate::error::BenchError;
use calls::Calls;
use repeated::Repeated;
use rusty_engine::run::Stop;
use rusty_engine::scenario_file;

/// What is measured.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Numbers of estimators.
    pub clients: Vec<usize>,
    /// Numbers of beams.
    pub beams: Vec<u32>,
    /// A scan in every Nth tick; 0: none.
    pub scan_every: Vec<u64>,
    /// Also server, estimator, scorer and logger.
    pub mix: bool,
    /// A program that is measured in the place of one dead reckoning, in turns
    /// with it. Empty: none.
    pub beside: Vec<String>,
    /// Ticks of a repetition, without the warm-up.
    pub ticks: usize,
    /// Repetitions.
    pub repeat: usize,
    /// How everyone waits.
    pub wait: WaitPolicy,
    /// Cores: the server's, then the clients' in turn. Empty: as the kernel likes.
    pub pin: Vec<usize>,
    /// Whether to say how far it is.
    pub quiet: bool,
}

/// The columns: quantiles; ratios; ticks in order; what a tick uses; another program.
const TABLES: [&[(&str, usize)]; 5] = [
    &[("p50_ns", 0), ("p90_ns", 0), ("p99_ns", 0), ("p99_9_ns", 0), ("max_ns", 0), ("per_s", 0)],
    &[
        ("p50_by_repetition_ns", 0),
        ("raw_p50_ns", 0),
        ("floor_p50_ns", 0),
        ("tick_over_raw", 2),
        ("raw_over_floor", 2),
    ],
    &[("in_order_p50_ns", 0), ("in_order_per_s", 0), ("tick_over_in_order", 2)],
    &[
        ("server_cpu_ns", 0),
        ("clients_cpu_ns", 0),
        ("server_sleeps", 4),
        ("server_yields", 3),
        ("clients_sleep", 4),
        ("clients_yield", 3),
        ("system_calls_per_tick", 3),
        ("system_calls", 0),
    ],
    &[("over_dead_reckoning", 2), ("over_dead_reckoning_ns", 0)],
];

/// One combination that is to be measured.
struct Case {
    roster: Vec<Participant>,
    config: RunConfig,
    /// The same as arguments of `launch`.
    launch: Vec<String>,
    who: String,
}

impl Plan {
    /// Measures. `None` if it was asked to stop.
    ///
    /// # Errors
    /// [`BenchError`] if a run cannot be set up or loses a participant.
    pub fn measure(
        &self,
        run: &RunName,
        stop: &Stop,
        noise: &mut NoiseMeter,
    ) -> Result<Option<Results>, BenchError> {
        let stage = Stage {
            run,
            wait: self.wait,
            rounds: self.ticks,
            warm_up: (self.ticks / 10).max(200),
            pin: &self.pin,
            stop,
        };
        let cases = self.cases()?;
        let mut rows = Vec::new();
        for (i, case) in cases.iter().enumerate() {
            if !self.quiet {
                errln!("  {} of {}: {}", i + 1, cases.len(), case.title());
            }
            match self.row(case, &stage, noise)? {
                Some(found) => rows.extend(found),
                None => return Ok(None),
            }
        }
        let results = Results::new(&TABLES, rows)
            .fact("wait", self.wait.to_string())
            .fact("pin", self.pin.clone())
            .fact("ticks", self.ticks)
            .fact("repeat", self.repeat);
        Ok(Some(results))
    }

    /// The row of a case, and one of the other program in it.
    fn row(
        &self,
        case: &Case,
        stage: &Stage<'_>,
        noise: &mut NoiseMeter,
    ) -> Result<Option<Vec<Row>>, BenchError> {
        let clients = case.roster.len();
        let (mut tick, mut in_order) = (Vec::new(), Vec::new());
        let (mut raw, mut floor) = (Vec::new(), Vec::new());
        let (mut other, other_roster) = (Vec::new(), replaced(&case.roster, &self.beside));
        for _ in 0..self.repeat {
            let samples = (
                stage.ticks(&case.config, &case.roster, true)?,
                stage.ticks(&case.config, &case.roster, false)?,
                stage.bare(Bare::Raw, clients)?,
                stage.bare(Bare::Floor, clients)?,
            );
            let (Some(a), Some(b), Some(c), Some(d)) = samples else { return Ok(None) };
            tick.push(a);
            in_order.push(b);
            raw.push(c);
            floor.push(d);
            if !self.beside.is_empty() {
                let Some(e) = stage.ticks(&case.config, &other_roster, true)? else {
                    return Ok(None);
                };
                other.push(e);
            }
            noise.look();
        }
        let system_calls = self.system_calls(stage, &case.launch)?;
        if stage.stop.is_raised() {
            return Ok(None);
        }
        let (tick, in_order) = (Repeated::of(tick), Repeated::of(in_order));
        let (raw, floor) = (Repeated::of(raw), Repeated::of(floor));
        let mut row = case.row(&case.title());
        row = tick.measured.put(row, "");
        row = in_order.measured.put(row, "in_order_");
        row = raw.measured.put(row, "raw_");
        row = floor.measured.put(row, "floor_");
        row = row
            .with("tick_over_in_order", tick.over(&in_order))
            .with("tick_over_raw", tick.over(&raw))
            .with("raw_over_floor", raw.over(&floor))
            .with("system_calls", calls::text(&system_calls));
        if let Ok(calls) = &system_calls {
            row = row.with("system_calls_per_tick", calls.values().sum::<f64>());
        }
        let mut rows = vec![row];
        if !other.is_empty() {
            let other = Repeated::of(other);
            let name = format!("{}, with {}", case.title(), self.beside.join(" "));
            rows.push(
                other
                    .measured
                    .put(case.row(&name), "")
                    .with("over_dead_reckoning", other.over(&tick))
                    .with("over_dead_reckoning_ns", other.compared(&tick, |a, b| a - b)),
            );
        }
        Ok(Some(rows))
    }

    /// Counts the system calls of a tick of `launch`, as these arguments
    /// have it.
    fn system_calls(&self, stage: &Stage<'_>, launch: &[String]) -> Result<Calls, BenchError> {
        // Its folder goes with the domain; the runs have separate names.
        let domain = Domain::create(stage.run)?;
        let folder = domain.folder().join("out");
        let mut args = launch.to_vec();
        let run = format!("{}-calls", stage.run);
        args.extend(["--run", &run, "--wait", &self.wait.to_string()].map(str::to_owned));
        args.extend(["--quiet", "--force", "--out"].map(str::to_owned));
        args.push(folder.display().to_string());
        let lengths = [stage.warm_up, stage.warm_up + stage.rounds];
        Ok(calls::count(&args, lengths, domain.folder(), stage.stop))
    }

    /// All combinations; without scans the number of beams does not matter.
    fn cases(&self) -> Result<Vec<Case>, BenchError> {
        let mut rosters: Vec<(Vec<Participant>, String)> =
            self.clients.iter().map(|n| (estimators(*n), count(*n, "estimator"))).collect();
        if self.mix {
            rosters.push((mix(), "estimator, scorer, logger".to_owned()));
        }
        let mut cases = Vec::new();
        for (roster, who) in &rosters {
            for &scan_every in &self.scan_every {
                let beams = if scan_every == 0 {
                    &self.beams[..1.min(self.beams.len())]
                } else {
                    &self.beams
                };
                for beams in beams {
                    cases.push(Case::new(roster, who, *beams, scan_every)?);
                }
            }
        }
        Ok(cases)
    }
}

/// Returns the names of the rows of a run for the page.
#[must_use]
pub fn rows() -> Vec<String> {
    let plan = Plan {
        clients: vec![1, 2, 3, 8],
        beams: vec![180, 1080],
        scan_every: vec![0, 1],
        mix: true,
        beside: Vec::new(),
        ticks: 20_000,
        repeat: 5,
        wait: WaitPolicy::default(),
        pin: Vec::new(),
        quiet: true,
    };
    // The scenario is a built-in one.
    plan.cases().unwrap_or_default().iter().map(Case::title).collect()
}

/// The roster with the program in the place of the first estimator.
fn replaced(roster: &[Participant], command: &[String]) -> Vec<Participant> {
    let mut roster = roster.to_vec();
    if let Some(first) = roster.iter_mut().find(|p| p.role == Role::Estimator) {
        first.command = command.to_vec();
    }
    roster
}

fn count(n: usize, noun: &str) -> String {
    format!("{n} {noun}{}", if n == 1 { "" } else { "s" })
}

impl Case {
    fn new(
        roster: &[Participant],
        who: &str,
        beams: u32,
        scan_every: u64,
    ) -> Result<Self, BenchError> {
        let changes = [format!("scan_every={scan_every}"), format!("lidar.beams={beams}")];
        let loaded = scenario_file::load("apartment", &changes)?;
        let mut launch = vec!["launch".to_owned(), "apartment".to_owned()];
        launch.extend(changes.iter().flat_map(|c| ["--set".to_owned(), c.clone()]));
        // The scenario's own participants, but for those that are not measured.
        for participant in &loaded.scenario.participants {
            let name = &participant.name;
            if !roster.iter().any(|p| p.name == *name) {
                launch.extend(["--without".to_owned(), name.clone()]);
            }
        }
        for participant in roster.iter().filter(|p| p.role == Role::Estimator) {
            let command = participant.command.join(" ");
            launch.extend(["--add".to_owned(), format!("{}={command}", participant.name)]);
        }
        let config = loaded.config()?;
        Ok(Self { roster: roster.to_vec(), config, launch, who: who.to_owned() })
    }

    /// A row with what the case is, in numbers.
    fn row(&self, name: &str) -> Row {
        let scan_every = self.config.scan_every;
        let row = Row::new(name).with("clients", self.roster.len()).with("scan_every", scan_every);
        let beams = u64::from(self.config.lidar.beams);
        if scan_every > 0 { row.with("beams", beams) } else { row }
    }

    fn title(&self) -> String {
        let (beams, scan_every) = (self.config.lidar.beams, self.config.scan_every);
        format!("{}, {}", self.who, scans(scan_every, beams))
    }
}

/// In words: which ticks have a scan.
fn scans(scan_every: u64, beams: u32) -> String {
    match scan_every {
        0 => "no scans".to_owned(),
        1 => format!("{beams} beams in every tick"),
        n => format!("{beams} beams in every {n}th tick"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(mix: bool) -> Plan {
        Plan {
            clients: vec![1, 3],
            beams: vec![180, 1080],
            scan_every: vec![0, 5],
            mix,
            beside: Vec::new(),
            ticks: 100,
            repeat: 1,
            wait: WaitPolicy::Balanced,
            pin: Vec::new(),
            quiet: true,
        }
    }

    #[test]
    fn without_scans_the_number_of_beams_is_no_case() {
        let cases = plan(false).cases().unwrap();
        let titles: Vec<String> = cases.iter().map(Case::title).collect();
        assert_eq!(titles.len(), 2 * (1 + 2));
        assert_eq!(titles[0], "1 estimator, no scans");
        assert_eq!(titles[5], "3 estimators, 1080 beams in every 5th tick");
        assert_eq!(cases[3].roster.len(), 3);
    }

    #[test]
    fn the_mix_keeps_the_scenario_s_scorer_and_logger() {
        let cases = plan(true).cases().unwrap();
        let mix = cases.last().unwrap();
        assert_eq!(mix.roster.len(), 3);
        let launch = mix.launch.join(" ");
        assert!(launch.contains("--without dead-reckoning"), "{launch}");
        assert!(!launch.contains("--without score"), "{launch}");
        assert!(launch.contains("--add estimator-0=dead-reckoning"), "{launch}");
    }

    #[test]
    fn the_page_has_a_row_for_each_combination() {
        let rows = rows();
        assert_eq!(rows.len(), 5 * 3);
        assert_eq!(rows[0], "1 estimator, no scans");
        assert_eq!(rows[14], "estimator, scorer, logger, 1080 beams in every tick");
    }

    #[test]
    fn one_estimator_is_replaced_and_nobody_else() {
        let command = ["python3".to_owned(), "my_filter.py".to_owned()];
        let (before, after) = (mix(), replaced(&mix(), &command));
        assert_eq!((&after[0].name, &after[0].command[..]), (&before[0].name, &command[..]));
        assert_eq!(after[1..], before[1..]);
    }
}
