//! `bench latency`: a tick of the protocol beside the transport alone and the
//! machine alone.
//!
//! For each number of clients, beams and scans there are repetitions; each is a
//! run of the server with real client processes, then the transport without a
//! protocol ([`rusty_link::raw`]), then the machine's floor
//! ([`rusty_link::floor`]), with as many processes that wait in the same way. So
//! whatever disturbs the machine meets all three, and the ratios are taken
//! within a repetition.

mod beside;
mod calls;
pub mod section;
mod table;

pub use beside::Beside;
pub use calls::SystemCalls;
pub use table::print;

use rusty_contract::{Participant, Role, RunConfig, RunName, errln};
use rusty_link::WaitPolicy;
use serde::{Deserialize, Serialize};

use super::noise::NoiseMeter;
use super::quantiles::{Quantiles, Spread};
use super::stage::{Bare, Stage, estimators, mix};
use super::stamps::{Sample, UsePerRound, Used};
use crate::error::BenchError;
use rusty_engine::run::Stop;
use rusty_engine::scenario_file;

/// What is measured.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Numbers of estimators.
    pub clients: Vec<usize>,
    /// Numbers of beams.
    pub beams: Vec<u32>,
    /// A scan in every so-manyth tick; 0: none.
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

/// What came of it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Results {
    /// How everyone waited.
    pub wait: String,
    /// The cores everyone was kept on; empty: the kernel chose.
    pub pin: Vec<usize>,
    /// Ticks of a repetition.
    pub ticks: usize,
    /// Repetitions.
    pub repeat: usize,
    /// A row for each combination.
    pub rows: Vec<Row>,
}

/// One combination.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Row {
    /// Client processes.
    pub clients: usize,
    /// Who they are.
    pub who: String,
    /// Beams of a scan; none where there are no scans.
    pub beams: Option<u32>,
    /// A scan in every so-manyth tick; 0: none.
    pub scan_every: u64,
    /// A full tick: step, digest, seal, publish, answers, close.
    pub tick: Measured,
    /// Frame and answers over the transport, without a protocol.
    pub raw: Measured,
    /// A number there and back, a cache line each.
    pub floor: Measured,
    /// Median tick over median raw round, in each repetition.
    pub tick_over_raw: Spread,
    /// Median raw round over median round of the floor, in each repetition.
    pub raw_over_floor: Spread,
    /// System calls of a tick, all processes together.
    pub system_calls: SystemCalls,
    /// The same with another program, if that was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub beside: Option<Beside>,
}

/// Rounds of one kind.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Measured {
    /// The rounds of all repetitions.
    pub all: Quantiles,
    /// The medians of the repetitions, ns.
    pub p50_ns: Spread,
    /// Rounds per second in the repetitions.
    pub per_s: Spread,
    /// What the server used for each.
    pub server: UsePerRound,
    /// What all clients together used for each.
    pub clients: UsePerRound,
}

/// One combination that is to be measured.
struct Case {
    roster: Vec<Participant>,
    config: RunConfig,
    /// The same as arguments of `launch`.
    launch: Vec<String>,
    who: String,
}

impl Plan {
    /// Measures. `None` if somebody wanted it to stop.
    ///
    /// # Errors
    /// [`BenchError`] if a run cannot be set up or loses somebody.
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
                Some(row) => rows.push(row),
                None => return Ok(None),
            }
        }
        Ok(Some(Results {
            wait: self.wait.to_string(),
            pin: self.pin.clone(),
            ticks: self.ticks,
            repeat: self.repeat,
            rows,
        }))
    }

    fn row(
        &self,
        case: &Case,
        stage: &Stage<'_>,
        noise: &mut NoiseMeter,
    ) -> Result<Option<Row>, BenchError> {
        let clients = case.roster.len();
        let (mut tick, mut raw, mut floor) = (Vec::new(), Vec::new(), Vec::new());
        let (mut other, other_roster) = (Vec::new(), beside::replaced(&case.roster, &self.beside));
        for _ in 0..self.repeat {
            let samples = (
                stage.ticks(&case.config, &case.roster)?,
                stage.bare(Bare::Raw, clients)?,
                stage.bare(Bare::Floor, clients)?,
            );
            let (Some(a), Some(b), Some(c)) = samples else { return Ok(None) };
            tick.push(a);
            raw.push(b);
            floor.push(c);
            if !self.beside.is_empty() {
                let Some(d) = stage.ticks(&case.config, &other_roster)? else { return Ok(None) };
                other.push(d);
            }
            noise.look();
        }
        let system_calls = self.system_calls(stage, &case.launch)?;
        if stage.is_stopped() {
            return Ok(None);
        }
        let (tick, raw, floor) = (Repeated::of(tick), Repeated::of(raw), Repeated::of(floor));
        let ratio = |a: &Repeated, b: &Repeated| {
            Spread::of(a.p50_ns.iter().zip(&b.p50_ns).map(|(a, b)| a / b.max(1.0)))
        };
        let beside = (!other.is_empty()).then(|| Repeated::of(other));
        let scan_every = case.config.scan_every;
        Ok(Some(Row {
            clients,
            who: case.who.clone(),
            beams: (scan_every > 0).then_some(case.config.lidar.beams),
            scan_every,
            tick_over_raw: ratio(&tick, &raw),
            raw_over_floor: ratio(&raw, &floor),
            beside: beside.map(|there| Beside::of(&self.beside, there, &tick)),
            tick: tick.measured,
            raw: raw.measured,
            floor: floor.measured,
            system_calls,
        }))
    }

    /// Counts the system calls of a tick of `launch`, as these arguments
    /// have it.
    fn system_calls(
        &self,
        stage: &Stage<'_>,
        launch: &[String],
    ) -> Result<SystemCalls, BenchError> {
        // Its folder goes with the domain; the runs have a name of their own.
        let (domain, _) = stage.domain()?;
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

    fn title(&self) -> String {
        let (beams, scan_every) = (self.config.lidar.beams, self.config.scan_every);
        format!("{}, {}", self.who, scans(scan_every, Some(beams)))
    }
}

/// In words: which ticks have a scan.
fn scans(scan_every: u64, beams: Option<u32>) -> String {
    match (scan_every, beams) {
        (0, _) | (_, None) => "no scans".to_owned(),
        (1, Some(beams)) => format!("{beams} beams in every tick"),
        (n, Some(beams)) => format!("{beams} beams in every {n}th tick"),
    }
}

/// The repetitions of one kind, put together.
struct Repeated {
    p50_ns: Vec<f64>,
    measured: Measured,
}

impl Repeated {
    fn of(samples: Vec<Sample>) -> Self {
        let (mut p50_ns, mut per_s, mut all) = (Vec::new(), Vec::new(), Vec::new());
        let mut used = Used::default();
        for mut sample in samples {
            let q = Quantiles::of(&mut sample.durations_ns);
            p50_ns.push(q.p50_ns as f64);
            per_s.push(if q.mean_ns > 0.0 { 1e9 / q.mean_ns } else { 0.0 });
            used = used + sample.used;
            all.append(&mut sample.durations_ns);
        }
        let rounds = all.len();
        let measured = Measured {
            all: Quantiles::of(&mut all),
            p50_ns: Spread::of(p50_ns.iter().copied()),
            per_s: Spread::of(per_s),
            server: UsePerRound::of(&used.server, rounds),
            clients: UsePerRound::of(&used.clients, rounds),
        };
        Self { p50_ns, measured }
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
    fn repetitions_are_put_together() {
        let sample = |ns: u64| Sample { durations_ns: vec![ns; 4], used: Used::default() };
        let repeated = Repeated::of(vec![sample(1000), sample(3000), sample(2000)]);
        assert_eq!(repeated.measured.all.count, 12);
        let p50 = repeated.measured.p50_ns;
        assert_eq!((p50.min, p50.median, p50.max), (1000.0, 2000.0, 3000.0));
        assert_eq!(repeated.measured.per_s.median, 500_000.0);
    }
}
