//! From a recording to a run log on disk.

use std::io::{BufWriter, Write};
use std::path::Path;
use std::rc::Rc;

use rusty_contract::log::{LogError, LogWriter, TickRef, Trailer};
use rusty_contract::output::same_file;
use rusty_contract::{Frame, Replacement, Reply, RunDigest, TruthKey};
use rusty_geometry::Twist;

use super::plan::{Plan, plan};
use super::preview::Preview;
use super::recording::{Event, Events, Recording};
use super::survey::{Before, Survey, drive, look};
use super::wheels::{Mount, Tick, Wheels};
use super::{ImportError, ImportReport, Progress};

/// Frames are sealed on the way to their digest, and digests do not depend on
/// the key; nothing sealed with it is written.
const ANY_KEY: [u8; 32] = [0; 32];

/// The way in which a recording is imported.
#[derive(Clone, Copy, Debug)]
pub struct ImportOptions<'a> {
    /// Program and version, for the header.
    pub writer: &'a str,
    /// Refuse a recording that has findings.
    pub strict: bool,
}

/// Imports the CARMEN log `input`, plain or gzip, into the run log `output`.
///
/// Each odometry reading and each scan becomes one tick, in file order and with
/// the file's own stamp as its time, bit for bit (a record that holds no stamp
/// has the one that `dt_s` implies, as in every run log). Where the stamps stand
/// still, all times are those that `dt_s` implies. Scans carry the corrected pose
/// as truth. The header names the writer, the file without its folder, in its
/// remarks all that the conversion assumed or left out, and in its findings the
/// defects of the recording.
///
/// `input` is read four times; `progress` receives how many of its lines are done,
/// in thousands, ending with all of them. The log is written next to `output` under another
/// name and renamed when it is complete, so that an existing file is replaced
/// by a whole log or not at all.
///
/// # Errors
/// [`ImportError`] names file, line, field, value and remedy. A log without
/// scans is no error; one without odometry is.
pub fn import_carmen(
    input: &Path,
    output: &Path,
    options: ImportOptions<'_>,
    progress: &mut dyn FnMut(u64),
) -> Result<ImportReport, ImportError> {
    let mut progress = Progress::new(progress);
    let preview = Preview::read(input, &mut progress)?;
    progress.pass(preview.lines);
    let (has_echoes, detached) = (preview.has_echoes(), Rc::from(preview.detached()));
    let open = || {
        let recording = Recording::open(input, has_echoes, Rc::clone(&detached))?;
        Ok(Box::new(recording) as Box<dyn Events>)
    };
    import(input, output, options, Before::Carmen(Box::new(preview)), &open, &mut progress)
}

/// Imports a recording whose kind is known, and which `open` opens again for each pass.
pub(super) fn import(
    input: &Path,
    output: &Path,
    options: ImportOptions<'_>,
    before: Before,
    open: &dyn Fn() -> Result<Box<dyn Events>, ImportError>,
    progress: &mut Progress<'_>,
) -> Result<ImportReport, ImportError> {
    check_two_files(input, output)?;
    let mut recording = open()?;
    let survey = look(&mut *recording, before, progress)?;
    progress.pass(recording.facts().line);
    if !survey.has_odometry() {
        return Err(no_odometry(input, &survey));
    }

    let mount = survey.mount();
    let mut recording = open()?;
    let driven = drive(&mut *recording, mount, survey.ranges.max().m, progress)?;
    progress.pass(recording.facts().line);

    let plan = plan(input, options.writer, &survey, &driven)?;
    if options.strict && !plan.report.findings.is_empty() {
        let (path, findings) = (input.display().to_string(), plan.report.findings);
        return Err(ImportError::Strict { path, findings });
    }
    let mut recording = open()?;
    write(&mut *recording, output, &plan, mount, progress)?;
    progress.pass(recording.facts().line);
    Ok(plan.report)
}

pub(super) fn check_two_files(input: &Path, output: &Path) -> Result<(), ImportError> {
    // A path that cannot be resolved is told where it is opened.
    if same_file(input, output) {
        let problem = "input and output are the same file; give the output another name";
        return Err(ImportError::file(output, problem));
    }
    Ok(())
}

fn no_odometry(input: &Path, survey: &Survey) -> ImportError {
    let mut hint = String::new();
    if survey.scans > 0 {
        hint += &format!("; {} scans alone do not tell how the wheels turned", survey.scans);
    }
    if survey.anchors > 0 {
        hint += &format!(", {} ODOM lines only echo their poses", survey.anchors);
    }
    if !survey.skipped.is_empty() {
        let types: Vec<&str> = survey.skipped.keys().take(8).map(String::as_str).collect();
        hint += &format!("; what stands there is {}", types.join(", "));
    }
    let problem = format!(
        "no odometry in {} lines (no ODOM message, no FLASER with an odometry pose of its \
         own){hint}; import a CARMEN log with ODOM lines",
        survey.lines
    );
    ImportError::file(input, problem)
}

/// Reads the recording once more and writes the run log.
fn write(
    recording: &mut dyn Events,
    output: &Path,
    plan: &Plan,
    mount: Mount,
    progress: &mut Progress<'_>,
) -> Result<(), ImportError> {
    let failed = |action| {
        move |error: std::io::Error| {
            let problem = format!("{action}: {error}; choose a folder that can be written to");
            ImportError::file(output, problem)
        }
    };
    let partial = Replacement::of(output).map_err(failed("creating the run log"))?;
    let buffer = BufWriter::with_capacity(1 << 16, partial);
    let mut log = LogWriter::new(buffer, output, &plan.header)?;
    let mut wheels = Wheels::new(mount);
    let mut ticks = Ticks::new(plan);
    while let Some(event) = recording.next_event()? {
        progress.at(event.line());
        if let Some(tick) = wheels.take(&event) {
            let ranges_m = match event {
                Event::Scan { ranges_m, .. } => Some(ranges_m),
                _ => None,
            };
            ticks.write(&mut log, &tick, ranges_m)?;
        }
    }
    if ticks.done != plan.header.config.ticks || recording.facts().line != plan.report.lines {
        let problem = "the file changed while it was read; import it again when it is complete";
        return Err(ImportError::file(Path::new(recording.facts().path), problem));
    }
    let buffer = log.finish(ticks.trailer())?;
    let partial = buffer
        .into_inner()
        .map_err(std::io::IntoInnerError::into_error)
        .map_err(|error| LogError::Io { path: output.display().to_string(), error })?;
    partial.commit(output).map_err(failed("completing the run log"))
}

/// The ticks written so far.
struct Ticks {
    frame: Box<Frame>,
    key: TruthKey,
    digest: RunDigest,
    dt_s: f64,
    /// Times are numbered, for the stamps stand still.
    numbered: bool,
    done: u64,
}

impl Ticks {
    fn new(plan: &Plan) -> Self {
        Self {
            frame: Frame::boxed(),
            key: TruthKey::from_bytes(ANY_KEY),
            digest: RunDigest::default(),
            dt_s: plan.header.config.dt_s,
            numbered: plan.numbered,
            done: 0,
        }
    }

    /// Writes a tick as a logger would have, had the robot been here: the
    /// digests are those of the frames that a replay will show.
    fn write<W: Write>(
        &mut self,
        log: &mut LogWriter<W>,
        tick: &Tick,
        ranges_m: Option<&[f64]>,
    ) -> Result<(), ImportError> {
        let frame = &mut self.frame;
        let numbered_s = (self.done + 1) as f64 * self.dt_s;
        let time_s = if self.numbered { numbered_s } else { tick.stamp_s };
        frame.begin(self.done, time_s, tick.counts, Twist::default());
        if let Some(ranges_m) = ranges_m {
            frame.write_scan(ranges_m.len()).copy_from_slice(ranges_m);
        }
        frame.seal(&self.key, tick.truth);
        self.digest.absorb_frame(frame, tick.truth);
        let replies: &[Reply] = &[];
        self.digest.absorb_replies(replies.iter().copied());
        log.tick(TickRef::new(frame, tick.truth, replies, self.dt_s))?;
        self.done += 1;
        Ok(())
    }

    fn trailer(&self) -> Trailer {
        Trailer {
            ticks: self.done,
            run_digest: self.digest.run(),
            world_digest: self.digest.world(),
        }
    }
}
