//! `verify`: simulate a log's run again and compare every bit.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, bail};
use clap::Args;
use rusty_contract::digest::{ObservableDigest, hex};
use rusty_contract::log::{Ending, LogReader, Read, ReadEntry, Source, TickRecord, Trailer};
use rusty_contract::{
    Effects, Exit, FieldError, Frame, LogHeader, Phase, Reply, RunDigest, Scenario, TruthKey,
    errln, outln,
};
use rusty_engine::run::{Pace, fresh_name};
use rusty_engine::source::FrameSource as _;
use rusty_link::WaitPolicy;
use rusty_logs::compare::{self, Mismatch, record_of};
use rusty_logs::comparison::Compared;
use rusty_logs::drivers::Driven;
use rusty_logs::original::Compare as _;
use rusty_logs::replay::Recording;
use serde::Serialize;

use super::arguments::{Output, RunArgs};
use super::session::{FinishedRun, RunPlace, RunSession, Starting};

#[derive(Args, Clone, Debug)]
pub struct VerifyArgs {
    /// Log to read
    pub log: PathBuf,
    /// Run the estimators and the driver again and compare answers
    #[arg(long)]
    pub clients: bool,
    /// Log of another robot of the run that has a driver
    #[arg(long, value_name = "LOG")]
    pub with: Vec<PathBuf>,
    #[command(flatten)]
    pub output: Output,
}

#[derive(Debug, Serialize)]
struct Verdict {
    /// Every bit is what it should be.
    bit_exact: bool,
    /// The log has its trailer.
    complete: bool,
    /// Frames were simulated again (not possible for a recording).
    re_simulated: bool,
    /// Ticks that were checked.
    ticks: u64,
    /// Run digest over them.
    digest: String,
    /// The first value that differs: the log's and the one expected.
    first_difference: Option<Mismatch>,
    /// With `--clients`: whose answers were compared, and how many.
    clients: Option<Clients>,
    remarks: Vec<String>,
}

/// Exits with 0 if the log is bit-exact, 4 if not, 3 if it is bit-exact but cut off.
pub fn run(args: &VerifyArgs) -> Result<Exit> {
    let mut verdict = check(&args.log, &args.with)?;
    if args.clients {
        verdict.add_clients(run_clients(&args.log)?);
    }
    args.output.print_with(&verdict, || print(&verdict));
    Ok(match (verdict.bit_exact, verdict.complete) {
        (true, true) => Exit::Done,
        (true, false) => Exit::Lost,
        (false, _) => Exit::NotBitExact,
    })
}

impl Verdict {
    /// Adds the answers of the clients. The earlier difference is kept; in a tick the
    /// frame precedes the answers to it.
    fn add_clients(&mut self, mut clients: Clients) {
        self.remarks.append(&mut clients.remarks);
        self.complete &= !clients.interrupted;
        if let Some(theirs) = clients.first_difference.take() {
            self.bit_exact = false;
            let earlier = self.first_difference.as_ref().is_none_or(|m| theirs.tick < m.tick);
            self.first_difference =
                if earlier { Some(theirs) } else { self.first_difference.take() };
        }
        self.clients = Some(clients);
    }
}

fn print(v: &Verdict) {
    for remark in &v.remarks {
        errln!("{remark}");
    }
    if let Some(m) = &v.first_difference {
        let (tick, place) = (m.tick, m.place());
        outln!("not bit-exact: tick {tick}, {place}: the log has {}, expected was {}", m.a, m.b);
    } else if !v.bit_exact {
        outln!("not bit-exact: {}", v.remarks.join("; "));
    } else {
        let how = if v.re_simulated { "bit-exact" } else { "intact" };
        let mut line = format!("{how}: {} ticks, digest {}", v.ticks, v.digest);
        for p in v.clients.iter().flat_map(|c| &c.participants) {
            line += &format!(", {} answers of {}", p.compared, p.name);
        }
        outln!("{line}");
    }
}

/// The simulation that is compared with the log.
struct Again {
    world: Driven,
    effects: Effects,
    frame: Box<Frame>,
}

impl Again {
    fn new(header: &LogHeader, others: &[PathBuf]) -> Result<Option<Self>> {
        let Some(world) = Driven::new(header.clone(), others)? else { return Ok(None) };
        Ok(Some(Self { world, effects: Effects::of(header), frame: Frame::boxed() }))
    }

    /// The next tick as it should be.
    fn next(&mut self) -> Result<TickRecord> {
        let truth = self.world.step(self.effects.command(), &mut self.frame)?;
        Ok(record_of(&self.frame, truth))
    }

    /// Takes the command from the driver's answer, which is invalid in some damaged
    /// records.
    fn apply_replies(&mut self, record: &TickRecord) {
        let sound = |reply: &Reply| if reply.check().is_ok() { *reply } else { Reply::Missing };
        let (tick, has_scan) = (self.frame.tick(), self.frame.ranges_m().is_some());
        self.effects.close(tick, has_scan, record.replies.iter().map(sound));
    }
}

fn check(path: &Path, others: &[PathBuf]) -> Result<Verdict> {
    let mut reader = LogReader::open(path)?;
    let header = reader.header().clone();
    let mut again = Again::new(&header, others)?;
    let mut verdict = Verdict {
        bit_exact: true,
        complete: true,
        re_simulated: again.is_some(),
        ticks: 0,
        digest: String::new(),
        first_difference: None,
        clients: None,
        remarks: Vec::new(),
    };
    if again.is_none() {
        let what = if header.is_blind() { "a blind log" } else { "a recording" };
        verdict
            .remarks
            .push(format!("{what} cannot be simulated again: checksums and digests were checked"));
    }
    let mut observable = ObservableDigest::default();
    let key = TruthKey::from_bytes([0; 32]);
    let mut digest = RunDigest::default();
    let mut frame = Frame::boxed();
    let ending = loop {
        match reader.read()? {
            Read::Tick(entry) => {
                note_damage(&mut verdict, &entry, reader.damaged());
                let record = entry.record;
                record.write_frame(&mut frame, header.config.dt_s, &key);
                record.absorb(&frame, &mut digest);
                observable.absorb(&frame);
                if verdict.first_difference.is_none() {
                    compare_with(&mut again, &record, header.config.dt_s, &mut verdict)?;
                }
                verdict.ticks += 1;
            }
            Read::End(ending) => break ending,
        }
    };
    let unnamed = reader.damaged().saturating_sub(MOST_NAMED);
    if unnamed > 0 {
        verdict.remarks.push(format!("the checksums of {unnamed} more records fail"));
    }
    verdict.bit_exact &= verdict.first_difference.is_none();
    verdict.digest = digest.run_hex();
    compare_observable(&mut verdict, &header, &observable);
    match ending {
        Ending::Complete(trailer) => compare_trailer(&mut verdict, &trailer, &digest),
        Ending::Cut { ticks, at_byte, problem } => {
            verdict.complete = false;
            verdict.remarks.push(format!(
                "the log ends after {ticks} complete ticks, at byte {at_byte}: {problem}"
            ));
        }
    }
    Ok(verdict)
}

/// Compares a record with the next tick of the simulation. That ends where the log of
/// another robot does.
fn compare_with(
    again: &mut Option<Again>,
    record: &TickRecord,
    dt_s: f64,
    verdict: &mut Verdict,
) -> Result<()> {
    let Some(world) = again else { return Ok(()) };
    let expected = world.next()?;
    if let Some(robot) = world.world.ended() {
        let tick = verdict.ticks;
        verdict.remarks.push(format!(
            "the log of robot {robot} ends after {tick} ticks; what follows was not simulated again"
        ));
        verdict.complete = false;
        *again = None;
        return Ok(());
    }
    verdict.first_difference = compare::frames(record, &expected, dt_s);
    world.apply_replies(record);
    Ok(())
}

/// Number of damaged records that are named; the others are counted.
const MOST_NAMED: u64 = 100;

fn note_damage(verdict: &mut Verdict, entry: &ReadEntry, damaged: u64) {
    verdict.bit_exact &= entry.intact;
    if !entry.intact && damaged <= MOST_NAMED {
        // Its place in the log: the number in the record may be the damage.
        let (tick, at_byte) = (verdict.ticks, entry.at_byte);
        let remark = format!("tick {tick}: the checksum of its record (byte {at_byte}) fails");
        verdict.remarks.push(remark);
    }
}

/// A blind log says which frames it was made of.
fn compare_observable(verdict: &mut Verdict, header: &LogHeader, found: &ObservableDigest) {
    let Source::Blind { observable_digest, ticks, .. } = &header.source else { return };
    if *ticks != verdict.ticks {
        let remark = format!("the log has {} of the {ticks} ticks that were sealed", verdict.ticks);
        verdict.remarks.push(remark);
    } else if *observable_digest != found.hex() {
        verdict.bit_exact = false;
        verdict.remarks.push(format!(
            "the header's observable digest is {observable_digest}, the frames give {}",
            found.hex()
        ));
    }
}

fn compare_trailer(verdict: &mut Verdict, trailer: &Trailer, digest: &RunDigest) {
    if trailer.run_digest != digest.run() || trailer.world_digest != digest.world() {
        verdict.bit_exact = false;
        verdict.remarks.push(format!(
            "the trailer's digest is {}, the records give {}",
            hex(&trailer.run_digest),
            digest.run_hex()
        ));
    }
}

/// The result of running the clients again.
#[derive(Debug, Default, Serialize)]
struct Clients {
    /// Everyone who was run, in roster order.
    participants: Vec<Compared>,
    /// Ticks for which they were.
    ticks: u64,
    /// The first answer that is not the recorded one.
    #[serde(skip)]
    first_difference: Option<Mismatch>,
    /// The run did not come to its end.
    interrupted: bool,
    #[serde(skip)]
    remarks: Vec<String>,
}

/// Runs everyone who answers in `log` on its frames again.
fn run_clients(log: &Path) -> Result<Clients> {
    let (mut source, _) = Recording::open(log)?;
    let header = source.header_mut();
    header.roster.retain(|p| p.answers());
    // One that is lost again shows as a missing answer.
    header.on_loss = rusty_contract::OnLoss::Continue;
    if let Some(by_hand) = header.roster.iter().find(|p| p.command.is_empty()) {
        let problem = "is empty: it was started by hand, and the log does not say how";
        let remedy = "use `sim-server replay LOG --attach` and start it by hand again";
        let field = format!("participant {:?}, command", by_hand.name);
        return Err(FieldError::new(field, "[]", problem, remedy).into());
    }
    if header.roster.is_empty() || source.tick_count() == 0 {
        let remarks = vec!["the log has no answers to compare".to_owned()];
        return Ok(Clients { remarks, ..Clients::default() });
    }
    let folder = tempfile::tempdir().context("a temporary folder")?;
    let made = play(&mut source, folder.path())?;
    gather(&source, &made)
}

fn play(source: &mut Recording, folder: &Path) -> Result<FinishedRun> {
    let args = RunArgs {
        run: Some(fresh_name("verify")?),
        out: Some(folder.to_owned()),
        force: false,
        pace: Some(Pace::Max),
        watch: false,
        allow_origin: Vec::new(),
        paused: false,
        no_report: true,
        sandbox: None,
        data_sheet: None,
        wait: WaitPolicy::default(),
        answer_timeout: None,
        join_timeout: None,
        add: Vec::new(),
        without: Vec::new(),
        output: Output { json: false },
        quiet: true,
    };
    let place = RunPlace::find(&args, &source.header().config.scenario, &[])?;
    let defaults = Scenario::default();
    RunSession {
        args: &args,
        starting: Starting::Launch,
        answer_timeout_s: defaults.answer_timeout_s,
        join_timeout_s: defaults.join_timeout_s,
        announced: false,
    }
    .make(place, source)
}

fn gather(source: &Recording, made: &FinishedRun) -> Result<Clients> {
    let outcome = &made.outcome;
    if let Some(loss) = outcome.losses.iter().find(|l| l.tick.is_none()) {
        bail!(
            "participant {:?} could not be run again: {}; see that its program still starts as \
             the log's roster says (`sim-server info LOG`)",
            loss.name,
            loss.detail
        );
    }
    let mut clients = Clients {
        ticks: outcome.ticks,
        interrupted: outcome.phase == Phase::Interrupted || outcome.source_error.is_some(),
        ..Clients::default()
    };
    let remarks = &mut clients.remarks;
    remarks.extend(outcome.source_error.iter().map(ToString::to_string));
    for (slot, how) in &outcome.ended_badly {
        remarks.push(format!("{}: {how}", made.header.roster[*slot].name));
    }
    if clients.interrupted {
        remarks.push(format!("the answers were compared up to tick {}", outcome.ticks));
    }
    let Some(comparison) = source.comparison() else { return Ok(clients) };
    for p in comparison.participants.iter().filter(|p| p.unrecorded > 0) {
        remarks.push(format!(
            "{}: the log lacks its answers to {} ticks, because it had been lost",
            p.name, p.unrecorded
        ));
    }
    clients.participants.clone_from(&comparison.participants);
    clients.first_difference = comparison.first_difference.as_ref().map(|d| Mismatch {
        tick: d.tick,
        participant: Some(d.name.clone()),
        field: d.field.clone(),
        a: d.recorded.clone(),
        b: d.replayed.clone(),
    });
    Ok(clients)
}
