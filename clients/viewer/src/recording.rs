//! A log, decoded once: all its ticks, in memory.

use std::collections::BTreeMap;
use std::io::BufReader;
use std::path::Path;
use std::sync::Arc;

use rusty_clients::ClientError;
use rusty_clients::showing::failure;
use rusty_contract::belief::{BeliefReader, Found, file_name, tidy};
use rusty_contract::digest::{hex, observable_of};
use rusty_contract::log::{Ending, LogReader, Read, TickRecord};
use rusty_contract::{Effects, Frame, LogHeader, errln, input};
use rusty_ros::Description;

use crate::outbox::Bytes;
use crate::record::{Moment, Shown, belief};
use crate::scene::{Mode, Scene};

/// A log in memory.
pub struct Recording {
    /// What the log says of its run.
    pub header: LogHeader,
    /// Every tick.
    pub ticks: Vec<Arc<Moment>>,
    /// The time of every tick, s.
    pub times_s: Vec<f64>,
    /// The beliefs at their ticks: index of the estimator, and record.
    pub beliefs: BTreeMap<u64, Vec<(usize, Bytes)>>,
    /// Run digest of all ticks; `None` of a log without its end.
    pub digest: Option<String>,
    /// What is missing at the end of the log.
    pub cut: Option<String>,
}

/// Beliefs that were read and wait for the frame after which they were held, by tick:
/// digest of the frame, index of the estimator, record.
type Unchecked = BTreeMap<u64, Vec<(u64, usize, Bytes)>>;

impl Recording {
    /// Reads a log, and the beliefs that a scorer left next to it.
    ///
    /// # Errors
    /// [`ClientError`] if it is not a log or cannot be read.
    pub fn read(path: &Path) -> Result<Self, ClientError> {
        let mut reader = LogReader::open(path)?;
        let header = reader.header().clone();
        let dt_s = header.config.dt_s;
        let mut unchecked = beliefs_of(path, &header);
        let mut effects = Effects::of(&header);
        let mut frame = Frame::boxed();
        let (mut ticks, mut times_s, mut beliefs) = (Vec::new(), Vec::new(), BTreeMap::new());
        let ending = loop {
            let record = match reader.read()? {
                Read::Tick(entry) => entry.record,
                Read::End(ending) => break ending,
            };
            if let Some(found) = unchecked.remove(&record.tick) {
                record.write_unsealed(&mut frame, dt_s);
                let observable = observable_of(&frame);
                let fits = found.into_iter().filter(|(digest, ..)| *digest == observable);
                let fitting: Vec<(usize, Bytes)> = fits.map(|(_, i, bytes)| (i, bytes)).collect();
                beliefs.insert(record.tick, fitting);
            }
            times_s.push(record.time_s(dt_s));
            ticks.push(moment(record, &mut effects, dt_s).into());
        };
        let (digest, cut) = match ending {
            Ending::Complete(trailer) => (Some(hex(&trailer.run_digest)), None),
            Ending::Cut { ticks, problem, .. } => {
                (None, Some(format!("The log ends after {ticks} ticks: {problem}.")))
            }
        };
        Ok(Self { header, ticks, times_s, beliefs, digest, cut })
    }

    /// What a page is told of the log.
    #[must_use]
    pub fn scene(&self) -> Scene {
        let blind = self.header.is_blind();
        let remark = blind.then(|| "This log is blind: it has no true poses.".to_owned());
        let scene = Scene::of(&self.header, Mode::Log).with_digest(self.digest.clone());
        scene.with_remark(remark.or_else(|| self.cut.clone()))
    }

    /// Returns what an app is told of the log: the truth, unless the log is blind.
    #[must_use]
    pub fn description(&self) -> Description {
        Description { truth: !self.header.is_blind(), ..Description::of(&self.header) }
    }
}

fn moment(record: TickRecord, effects: &mut Effects, dt_s: f64) -> Moment {
    effects.close(record.tick, record.ranges_m.is_some(), record.replies.iter().copied());
    let shown: Vec<Shown> = effects
        .replies()
        .map(|reply| Shown { estimate: reply.estimate().copied(), times_ns: None })
        .collect();
    Moment {
        tick: record.tick,
        time_s: record.time_s(dt_s),
        counts: record.ticks,
        truth: record.pose_in_world().filter(rusty_geometry::SE2::is_finite),
        command: record.command,
        digest: [0; 16],
        shown,
        ranges_m: record.ranges_m,
        readings: record.readings,
    }
}

/// The beliefs in the files next to a log. A file that cannot be read is left out.
fn beliefs_of(log: &Path, header: &LogHeader) -> Unchecked {
    let mut all = Unchecked::new();
    for (index, participant) in header.answering().enumerate() {
        let path = log.with_file_name(file_name(&participant.name));
        if !path.is_file() {
            continue;
        }
        if let Err(e) = read_beliefs(&path, index, &mut all) {
            errln!("{e}; it is left out");
        }
    }
    all
}

fn read_beliefs(path: &Path, index: usize, all: &mut Unchecked) -> Result<(), ClientError> {
    let file = input::open(path).map_err(ClientError::io(path))?;
    let mut reader = BeliefReader::new(BufReader::new(file)).map_err(failure(path))?;
    while let Found::Moment { tick, observable, kind, whole, poses } =
        reader.next().map_err(failure(path))?
    {
        let mut poses = poses.to_vec();
        if tidy(&mut poses) > 0 {
            let record = belief(tick, index, (kind, whole), &poses).into();
            all.entry(tick).or_default().push((observable, index, record));
        }
    }
    Ok(())
}
