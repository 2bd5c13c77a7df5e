//! All measurements, in turn: everyone once, then everyone again, so that what
//! drifts on the machine drifts under all alike.

use std::io::IsTerminal as _;

use indicatif::{ProgressBar, ProgressStyle};
use rusty_bench::noise::NoiseMeter;
use rusty_bench::report::Report;
use rusty_contract::Exit;
use rusty_link::Domain;

use crate::cell;
use crate::cli::{CellPlan, ServerPlan, TourArgs};
use crate::contender::{Contender, Wait};
use crate::error::BenchError;
use crate::meter::Measured;
use crate::output::say;
use crate::stop::Stop;
use crate::table::{Absent, Case, Results, Settings};
use crate::transport;

/// Measures what `args` asks for and prints it.
pub fn main(args: &TourArgs) -> Exit {
    let stop = match Stop::listen() {
        Ok(stop) => stop,
        Err(e) => {
            say(format_args!("rusty-peers: signals cannot be listened for: {e}"));
            return Exit::Failed;
        }
    };
    let (present, absent) = attendance(args);
    for one in &absent {
        say(format_args!("{} is left out: {}", one.contender, one.reason));
    }
    let mut tour = Tour::new(args, present, &stop);
    let mut meter = NoiseMeter::begin();
    tour.go(&mut meter);
    // What killed processes may have left; living ones are not touched.
    transport::sweep();
    let _ = Domain::sweep_dead();
    let results = Results::of(Settings::of(args), tour.cases, absent);
    let mut report = Report::new("peers", meter.finish(), results.report());
    if let Some((_, rest)) = report.command.split_once(' ') {
        report.command = format!("rusty-peers {rest}");
    } else {
        report.command = "rusty-peers".to_owned();
    }
    let exit = report.finish(args.printing());
    results_exit(&results, stop.is_raised(), exit)
}

/// Who can take part, and who cannot.
fn attendance(args: &TourArgs) -> (Vec<Contender>, Vec<Absent>) {
    let wanted = |c: &Contender| *c == Contender::Ours || args.peers.contains(c);
    let mut absent = Vec::new();
    let mut present = Vec::new();
    for contender in Contender::ALL.into_iter().filter(wanted) {
        match contender.missing() {
            Some(reason) => absent.push(Absent { contender, reason }),
            None => present.push(contender),
        }
    }
    (present, absent)
}

fn results_exit(results: &Results, stopped: bool, otherwise: Exit) -> Exit {
    if !results.are_the_same_runs() {
        say("two contenders made different runs of the same seed: see the digests");
        return Exit::NotBitExact;
    }
    if stopped {
        say("interrupted: the table has what was complete");
        return Exit::Lost;
    }
    if results.has_failures() { Exit::Lost } else { otherwise }
}

struct Tour<'a> {
    args: &'a TourArgs,
    stop: &'a Stop,
    cases: Vec<Case>,
    bar: Option<ProgressBar>,
}

impl<'a> Tour<'a> {
    fn new(args: &'a TourArgs, present: Vec<Contender>, stop: &'a Stop) -> Self {
        let mut cases = Vec::new();
        for &clients in &args.clients {
            for wait in Wait::ALL.into_iter().filter(|wait| args.waits.contains(wait)) {
                let able = present.iter().filter(|contender| contender.waits().contains(&wait));
                cases.extend(able.map(|&contender| Case::new(contender, wait, clients)));
            }
        }
        let total = cases.len() as u64 * u64::from(args.repetitions);
        let bar = std::io::stderr().is_terminal().then(|| {
            let style = ProgressStyle::with_template("{bar:32} {pos}/{len}  {eta} left  {msg}");
            let bar = ProgressBar::new(total);
            bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
            bar
        });
        Self { args, stop, cases, bar }
    }

    /// Everyone in turn, as often as wanted, or until it is stopped.
    fn go(&mut self, meter: &mut NoiseMeter) {
        for repetition in 0..self.args.repetitions {
            self.say(&format!("repetition {} of {}", repetition + 1, self.args.repetitions));
            for i in 0..self.cases.len() {
                if self.stop.is_raised() {
                    break;
                }
                self.step(i);
                meter.look();
            }
        }
        if let Some(bar) = self.bar.take() {
            bar.finish_and_clear();
        }
    }

    fn step(&mut self, i: usize) {
        let case = &self.cases[i];
        let name = case.name();
        if let Some(bar) = &self.bar {
            bar.set_message(name.clone());
        }
        if !case.has_failed() {
            let (contender, wait, clients) = (case.contender, case.wait, case.clients);
            match measure(self.args, contender, wait, clients, self.stop) {
                Ok(measured) => self.cases[i].add(measured),
                Err(BenchError::Stopped) => {}
                Err(e) => {
                    self.say(&format!("{name} failed: {e}"));
                    self.cases[i].fail(e.to_string());
                }
            }
        }
        if let Some(bar) = &self.bar {
            bar.inc(1);
        }
    }

    fn say(&self, text: &str) {
        match &self.bar {
            Some(bar) => bar.suspend(|| say(text)),
            None => say(text),
        }
    }
}

/// One measurement in a separate folder.
fn measure(
    args: &TourArgs,
    contender: Contender,
    wait: Wait,
    clients: u32,
    stop: &Stop,
) -> Result<Measured, BenchError> {
    let folder = tempfile::Builder::new()
        .prefix("rusty-peers-")
        .tempdir()
        .map_err(BenchError::io(&std::env::temp_dir()))?;
    let cell = CellPlan {
        contender,
        wait,
        folder: folder.path().to_owned(),
        parent: std::process::id(),
        scans: args.scans,
    };
    let (ticks, warm_up) = (args.ticks, args.warm_up);
    let plan = ServerPlan { cell, clients: clients as usize, ticks, warm_up };
    cell::run(&plan, stop)
}
