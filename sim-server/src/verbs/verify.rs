//! `verify`: simulate a log's run again and compare every bit.

mod clients;

use rusty_contract::digest::{ObservableDigest, hex};
use rusty_contract::log::{Ending, LogReader, Read, ReadEntry, Source, TickRecord, Trailer};
use rusty_contract::{Effects, Exit, Frame, LogHeader, Reply, RunDigest, TruthKey, errln, outln};
use serde::Serialize;

use self::clients::Clients;
use super::{Verbed, print_json};
use crate::cli::VerifyArgs;
use crate::error::VerbError;
use rusty_engine::compare::{self, Mismatch};
use rusty_engine::source::{Course, record_of};

/// What a verification found.
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
    /// What else there is to say.
    remarks: Vec<String>,
}

/// Verifies a log: exit 0 if it is bit-exact, 4 if not, 3 if it is bit-exact
/// as far as it goes but cut off.
///
/// # Errors
/// [`VerbError`] if it is no log, or a participant cannot be run again.
pub fn verify(args: &VerifyArgs) -> Verbed {
    let mut verdict = check(&args.log)?;
    if args.clients {
        verdict.hear(clients::run(&args.log)?);
    }
    if args.json {
        print_json(&verdict);
    } else {
        print(&verdict);
    }
    Ok(match (verdict.bit_exact, verdict.complete) {
        (true, true) => Exit::Done,
        (true, false) => Exit::Lost,
        (false, _) => Exit::NotBitExact,
    })
}

impl Verdict {
    /// Takes in what the clients answered: of two differences the earlier one
    /// stands, and the frame's comes before the answers to it.
    fn hear(&mut self, mut clients: Clients) {
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

/// The simulation that runs beside the log.
struct Again {
    course: Course,
    effects: Effects,
    frame: Box<Frame>,
}

impl Again {
    fn new(header: &LogHeader) -> Result<Option<Self>, VerbError> {
        let Some(course) = Course::of(header)? else { return Ok(None) };
        Ok(Some(Self { course, effects: Effects::of(header), frame: Frame::boxed() }))
    }

    /// The next tick as it should be.
    fn next(&mut self) -> Result<TickRecord, VerbError> {
        let truth = self.course.step(self.effects.command(), &mut self.frame)?;
        Ok(record_of(&self.frame, truth))
    }

    /// What the log's driver said becomes a command. A damaged record may hold
    /// something that no driver could say.
    fn hear(&mut self, record: &TickRecord) {
        let sound = |reply: &Reply| if reply.check().is_ok() { *reply } else { Reply::Missing };
        let (tick, has_scan) = (self.frame.tick(), self.frame.ranges_m().is_some());
        self.effects.close(tick, has_scan, record.replies.iter().map(sound));
    }
}

fn check(path: &std::path::Path) -> Result<Verdict, VerbError> {
    let mut reader = LogReader::open(path)?;
    let header = reader.header().clone();
    let mut again = Again::new(&header)?;
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
                if let Some(again) = again.as_mut().filter(|_| verdict.first_difference.is_none()) {
                    let expected = again.next()?;
                    verdict.first_difference =
                        compare::frames(&record, &expected, header.config.dt_s);
                    again.hear(&record);
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

/// So many damaged records are named; of the others it is said how many.
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
