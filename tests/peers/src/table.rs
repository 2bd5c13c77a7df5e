//! What the measurements come to: quantiles, rates, ratios, one digest.

use std::fmt;

use rusty_bench::quantiles::{Quantiles, Spread};
use rusty_bench::results;
use rusty_contract::{Answer, Frame};

use crate::cli::TourArgs;
use crate::contender::{Contender, Wait};
use crate::meter::Measured;

/// The goal: the median tick of these, with this many clients, is this many times
/// ours.
const GOAL: f64 = 20.0;
const GOAL_CLIENTS: u32 = 3;
const GOAL_PEERS: [Contender; 2] = [Contender::Zmq, Contender::Zenoh];

/// One contender, waiting in one way, with N clients, measured again and
/// again.
pub struct Case {
    pub contender: Contender,
    pub wait: Wait,
    pub clients: u32,
    measured: Vec<Measured>,
    failure: Option<String>,
}

impl Case {
    pub fn new(contender: Contender, wait: Wait, clients: u32) -> Self {
        Self { contender, wait, clients, measured: Vec::new(), failure: None }
    }

    pub fn name(&self) -> String {
        let plural = if self.clients == 1 { "" } else { "s" };
        format!("{} {} with {} client{plural}", self.contender, self.wait, self.clients)
    }

    pub fn add(&mut self, measured: Measured) {
        self.measured.push(measured);
    }

    /// It failed and is not tried again.
    pub fn fail(&mut self, why: String) {
        self.failure = Some(why);
    }

    pub fn has_failed(&self) -> bool {
        self.failure.is_some()
    }

    fn row(self) -> Row {
        let p50_ns = self.measured.iter().map(|m| Quantiles::of(&mut m.ticks_ns.clone()).p50_ns);
        let p50_by_repetition_ns = Spread::of(p50_ns.map(|ns| ns as f64));
        let cpu_ns: Option<u64> = self.measured.iter().map(|m| m.cpu_ns).sum();
        let mut digests: Vec<String> = self.measured.iter().map(|m| m.digest.clone()).collect();
        // Bytes without a world make no run.
        digests.retain(|digest| !digest.is_empty());
        digests.sort();
        digests.dedup();
        let repetitions = self.measured.len();
        let mut ticks_ns: Vec<u64> = self.measured.into_iter().flat_map(|m| m.ticks_ns).collect();
        let tick = Quantiles::of(&mut ticks_ns);
        Row {
            contender: self.contender,
            wait: self.wait,
            clients: self.clients,
            repetitions,
            tick,
            p50_by_repetition_ns,
            ticks_per_s: if tick.mean_ns > 0.0 { 1e9 / tick.mean_ns } else { 0.0 },
            cpu_ns_per_tick: cpu_ns
                .filter(|_| tick.count > 0)
                .map(|ns| ns as f64 / tick.count as f64),
            times_ours_same_wait: None,
            times_ours: None,
            digests,
            failure: self.failure,
        }
    }
}

/// One line of the table.
#[derive(Clone, Debug)]
pub struct Row {
    pub contender: Contender,
    pub wait: Wait,
    pub clients: u32,
    /// How many repetitions are in it.
    pub repetitions: usize,
    /// From the beginning of a tick to that of the next, all repetitions.
    pub tick: Quantiles,
    /// Medians of the repetitions: how far to trust the row.
    pub p50_by_repetition_ns: Spread,
    pub ticks_per_s: f64,
    /// Processor time of the server and all clients.
    pub cpu_ns_per_tick: Option<f64>,
    /// Median over that of ours waiting in the same way.
    pub times_ours_same_wait: Option<f64>,
    /// Median over that of ours as it comes.
    pub times_ours: Option<f64>,
    /// Digests of the runs: one.
    pub digests: Vec<String>,
    /// Why it was given up.
    pub failure: Option<String>,
}

impl Row {
    fn figures(&self) -> results::Row {
        let row = results::Row::new(format!(
            "{}, {}, {} clients",
            self.contender, self.wait, self.clients
        ))
        .with("contender", self.contender.to_string())
        .with("wait", self.wait.to_string())
        .with("clients", u64::from(self.clients))
        .with("repetitions", self.repetitions)
        .with("digests", self.digests.join(", "));
        let row = match &self.failure {
            Some(why) => row.with("failure", why.clone()),
            None => row,
        };
        if self.tick.count == 0 {
            return row;
        }
        let row = row
            .with_quantiles("", &self.tick)
            .with("p50_by_repetition_ns", self.p50_by_repetition_ns)
            .with("ticks_per_s", self.ticks_per_s);
        let known = [
            ("cpu_ns_per_tick", self.cpu_ns_per_tick),
            ("times_ours_same_wait", self.times_ours_same_wait),
            ("times_ours", self.times_ours),
        ];
        let known = known.into_iter().filter_map(|(name, figure)| Some((name, figure?)));
        known.fold(row, |row, (name, figure)| row.with(name, figure))
    }
}

/// A contender that could not take part.
#[derive(Clone, Debug)]
pub struct Absent {
    pub contender: Contender,
    pub reason: String,
}

/// What was asked for.
#[derive(Clone, Debug)]
pub struct Settings {
    ticks: u64,
    warm_up: u64,
    repetitions: u32,
    scans: bool,
}

impl Settings {
    pub fn of(args: &TourArgs) -> Self {
        Self {
            ticks: args.ticks,
            warm_up: args.warm_up,
            repetitions: args.repetitions,
            scans: args.scans,
        }
    }
}

/// A goal, and the result.
#[derive(Clone, Debug)]
pub struct Goal {
    pub contender: Contender,
    pub clients: u32,
    pub at_least: f64,
    /// As people use it: it blocks, ours waits as it comes.
    pub as_used: Option<f64>,
    pub both_poll: Option<f64>,
    pub both_block: Option<f64>,
}

/// Everything.
#[derive(Clone, Debug)]
pub struct Results {
    pub settings: Settings,
    pub rows: Vec<Row>,
    pub absent: Vec<Absent>,
    pub goals: Vec<Goal>,
}

impl Results {
    /// Of all that was measured.
    pub fn of(settings: Settings, cases: Vec<Case>, absent: Vec<Absent>) -> Self {
        let mut rows: Vec<Row> = cases.into_iter().map(Case::row).collect();
        let medians: Vec<(Contender, Wait, u32, u64)> =
            rows.iter().map(|r| (r.contender, r.wait, r.clients, r.tick.p50_ns)).collect();
        let ours = |wait, clients| {
            let mine = (Contender::Ours, wait, clients);
            let found = medians.iter().find(|(c, w, k, _)| (*c, *w, *k) == mine);
            found.map(|(.., p50_ns)| *p50_ns).filter(|p50_ns| *p50_ns > 0)
        };
        for row in rows.iter_mut().filter(|row| row.tick.p50_ns > 0) {
            let times = |ours_ns: u64| row.tick.p50_ns as f64 / ours_ns as f64;
            row.times_ours_same_wait = ours(row.wait, row.clients).map(times);
            row.times_ours = ours(Wait::Balanced, row.clients).map(times);
        }
        let goals = goals(&rows);
        Self { settings, rows, absent, goals }
    }

    /// Whether all runs with the same number of clients have one digest.
    pub fn are_the_same_runs(&self) -> bool {
        self.rows.iter().all(|row| {
            let same = |other: &&Row| other.clients == row.clients;
            let all = self.rows.iter().filter(same).flat_map(|other| &other.digests);
            all.into_iter().all(|digest| row.digests.iter().all(|mine| mine == digest))
        })
    }

    /// Returns rows, settings and goals as the results of a benchmark.
    pub fn report(&self) -> results::Results {
        let columns = [
            ("p50_ns", 0),
            ("p90_ns", 0),
            ("p99_ns", 0),
            ("max_ns", 0),
            ("ticks_per_s", 0),
            ("cpu_ns_per_tick", 0),
            ("times_ours_same_wait", 1),
            ("times_ours", 1),
        ];
        let rows = self.rows.iter().map(Row::figures);
        let Settings { ticks, warm_up, repetitions, scans } = self.settings;
        let absent = self.absent.iter().map(|a| format!("{}: {}", a.contender, a.reason));
        let goals = self.goals.iter().map(ToString::to_string);
        results::Results::new(&[&columns, &[("failure", 0)]], rows)
            .fact("ticks", ticks)
            .fact("warm_up", warm_up)
            .fact("repetitions", repetitions)
            .fact("scans", scans)
            .fact("frame_bytes", size_of::<Frame>())
            .fact("answer_bytes", size_of::<Answer>())
            .fact("absent", absent.collect::<Vec<_>>())
            .fact("goals", goals.collect::<Vec<_>>())
    }

    /// Whether a contender was given up.
    pub fn has_failures(&self) -> bool {
        self.rows.iter().any(|row| row.failure.is_some())
    }
}

fn goals(rows: &[Row]) -> Vec<Goal> {
    let row = |contender, wait| {
        rows.iter().find(|r| (r.contender, r.wait, r.clients) == (contender, wait, GOAL_CLIENTS))
    };
    let of = |contender| {
        let (block, poll) = (row(contender, Wait::Block), row(contender, Wait::Poll));
        block.or(poll)?;
        Some(Goal {
            contender,
            clients: GOAL_CLIENTS,
            at_least: GOAL,
            as_used: block.and_then(|r| r.times_ours),
            both_poll: poll.and_then(|r| r.times_ours_same_wait),
            both_block: block.and_then(|r| r.times_ours_same_wait),
        })
    };
    GOAL_PEERS.into_iter().filter_map(of).collect()
}

impl fmt::Display for Goal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let verdict = |ratio: Option<f64>| match ratio {
            Some(ratio) if ratio >= self.at_least => format!("{ratio:.1}× (met)"),
            Some(ratio) => format!("{ratio:.1}× (missed)"),
            None => "not measured".to_owned(),
        };
        write!(
            f,
            "{} with {} clients, aimed at {:.0}×: as people use it {}; both polling {}; both \
             blocking {}",
            self.contender,
            self.clients,
            self.at_least,
            verdict(self.as_used),
            verdict(self.both_poll),
            verdict(self.both_block),
        )
    }
}

#[cfg(test)]
mod tests;
