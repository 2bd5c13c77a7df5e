//! A whole run log as arrays: what `rusty.read_log` is made of.

use std::collections::BTreeMap;
use std::path::PathBuf;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use rusty_contract::log::{Ending, LogError, LogReader, Read, TickRecord};
use rusty_contract::readings::SENSOR_NAMES;
use rusty_contract::{Frame, OwnedReadings, Reply, RunDigest, TruthKey};

use crate::arrays::shaped;
use crate::errors::RustyError;

/// One pass over a log: its columns, every tick a row.
#[derive(Default)]
struct Columns {
    /// The header in JSON.
    header: String,
    ticks: usize,
    time_s: Vec<f64>,
    encoders: Vec<i64>,
    commands: Vec<f64>,
    truth: Vec<f64>,
    /// Whether any tick has a truth.
    any_truth: bool,
    scan_ticks: Vec<i64>,
    scans_m: Vec<Vec<f64>>,
    /// Rows of each small sensor, by its name; the first number of a row is the tick.
    readings: BTreeMap<&'static str, (usize, Vec<f64>)>,
    answers: Vec<Answers>,
    digest: RunDigest,
    /// Ticks whose record is not what was written.
    damaged_ticks: Vec<i64>,
    /// Why it is not all that was written, in words.
    problem: Option<String>,
}

/// What one participant answered.
struct Answers {
    name: String,
    poses: Vec<f64>,
    /// Filled from the first covariance on.
    covariances: Option<Vec<f64>>,
    /// Filled from the first innovation on.
    innovations: Option<Vec<f64>>,
}

impl Answers {
    fn push(&mut self, ticks: usize, reply: Option<&Reply>) {
        let estimate = reply.and_then(Reply::estimate);
        let pose = estimate.map(|e| e.pose_in_world);
        self.poses.extend(pose.map_or([f64::NAN; 3], |p| [p.x(), p.y(), p.theta()]));
        fill(&mut self.covariances, ticks, estimate.and_then(|e| e.covariance));
        let innovation = estimate.and_then(|e| e.innovation);
        fill(&mut self.innovations, ticks, innovation.map(|i| [i.nis, f64::from(i.degrees)]));
    }
}

/// Adds a row of what is not always reported: NaN where it is not, and nothing at
/// all before the first time.
fn fill<const N: usize>(rows: &mut Option<Vec<f64>>, before: usize, row: Option<[f64; N]>) {
    if row.is_some() && rows.is_none() {
        *rows = Some(vec![f64::NAN; N * before]);
    }
    if let Some(rows) = rows {
        rows.extend(row.unwrap_or([f64::NAN; N]));
    }
}

impl Columns {
    /// Reads a log to wherever it ends.
    ///
    /// # Errors
    /// [`LogError`] if it is no log, or its header cannot be read.
    fn read(path: &std::path::Path) -> Result<Self, LogError> {
        let mut reader = LogReader::open(path)?;
        let header = reader.header();
        let dt_s = header.config.dt_s;
        let answers = |p: &rusty_contract::Participant| Answers {
            name: p.name.clone(),
            poses: Vec::new(),
            covariances: None,
            innovations: None,
        };
        let mut columns = Self {
            header: serde_json::to_string(header).unwrap_or_default(),
            answers: header.answering().map(answers).collect(),
            ..Self::default()
        };
        // The digest is over frames opened, whatever key they were sealed with.
        let (key, mut frame) = (TruthKey::from_bytes([0; 32]), Frame::boxed());
        let ending = loop {
            match reader.read()? {
                Read::Tick(entry) => {
                    entry.record.write_frame(&mut frame, dt_s, &key);
                    entry.record.absorb(&frame, &mut columns.digest);
                    if !entry.intact {
                        columns.damaged_ticks.push(columns.ticks as i64);
                    }
                    columns.push(entry.record, dt_s);
                }
                Read::End(ending) => break ending,
            }
        };
        columns.problem = columns.problem(&ending);
        Ok(columns)
    }

    fn push(&mut self, record: TickRecord, dt_s: f64) {
        self.time_s.push(record.time_s(dt_s));
        self.encoders.extend([record.ticks.left, record.ticks.right]);
        self.commands.extend([record.command.v_m_s, record.command.omega_rad_s]);
        self.any_truth |= record.truth.is_some();
        self.truth.extend(record.truth.unwrap_or([f64::NAN; 3]));
        for (i, answers) in self.answers.iter_mut().enumerate() {
            answers.push(self.ticks, record.replies.get(i));
        }
        self.read_small(&record.readings);
        if let Some(ranges_m) = record.ranges_m {
            self.scan_ticks.push(self.ticks as i64);
            self.scans_m.push(ranges_m);
        }
        self.ticks += 1;
    }

    fn read_small(&mut self, readings: &OwnedReadings) {
        let (tick, readings) = (self.ticks as f64, readings.get());
        let mut row = |name, numbers: &[f64]| {
            let (width, rows) = self.readings.entry(name).or_default();
            // A robot has as many sonars in every tick; a log that says otherwise was not
            // written by a server, and its rows stay as wide as the first.
            *width = if *width == 0 { 1 + numbers.len() } else { *width };
            rows.push(tick);
            let missing = std::iter::repeat(f64::NAN);
            rows.extend(numbers.iter().copied().chain(missing).take(*width - 1));
        };
        let [bumper, imu, sonars, doors, landmarks] = SENSOR_NAMES;
        if let Some(sectors) = readings.bumper() {
            row(bumper, &[sectors.into()]);
        }
        if let Some(read) = readings.imu() {
            row(imu, &[read.yaw_rate_rad_s, read.accel_x_m_s2, read.accel_y_m_s2]);
        }
        if let Some(ranges_m) = readings.sonar_ranges_m() {
            row(sonars, ranges_m);
        }
        if let Some(seen) = readings.doors() {
            seen.iter().for_each(|door| row(doors, &[*door]));
            if seen.is_empty() {
                row(doors, &[f64::NAN]);
            }
        }
        if let Some(all) = readings.landmarks() {
            for seen in all {
                let id = seen.id().map_or(-1.0, f64::from);
                row(landmarks, &[id, seen.range_m, seen.bearing_rad]);
            }
            if all.is_empty() {
                row(landmarks, &[f64::NAN; 3]);
            }
        }
    }

    fn problem(&self, ending: &Ending) -> Option<String> {
        match ending {
            Ending::Cut { ticks, at_byte, problem } => {
                Some(format!("it ends after {ticks} ticks (byte {at_byte}): {problem}"))
            }
            Ending::Complete(_) if !self.damaged_ticks.is_empty() => {
                let (n, first) = (self.damaged_ticks.len(), self.damaged_ticks[0]);
                Some(format!("the checksums of {n} records fail, the first at tick {first}"))
            }
            Ending::Complete(trailer) if trailer.run_digest != self.digest.run() => {
                Some("its digest is not that of its records".to_owned())
            }
            Ending::Complete(_) => None,
        }
    }

    /// Scans of one length, one after the other: shorter ones end in NaN.
    fn scans(&mut self) -> (Vec<f64>, [usize; 2]) {
        let beams = self.scans_m.iter().map(Vec::len).max().unwrap_or(0);
        let shape = [self.scans_m.len(), beams];
        let mut all = Vec::with_capacity(shape[0] * beams);
        for scan in std::mem::take(&mut self.scans_m) {
            all.extend_from_slice(&scan);
            all.resize(all.len() + beams - scan.len(), f64::NAN);
        }
        (all, shape)
    }
}

/// The columns of a log in a dictionary; see `rusty.RunLog` for what they are.
#[pyfunction]
fn read_columns(py: Python<'_>, path: PathBuf) -> PyResult<Bound<'_, PyDict>> {
    let mut columns = py.detach(|| Columns::read(&path)).map_err(raised)?;
    let (scans_m, scans) = columns.scans();
    let ticks = columns.ticks;
    let dict = PyDict::new(py);
    dict.set_item("header", &columns.header)?;
    dict.set_item("time_s", shaped(py, columns.time_s, [ticks])?)?;
    dict.set_item("encoders", shaped(py, columns.encoders, [ticks, 2])?)?;
    dict.set_item("commands", shaped(py, columns.commands, [ticks, 2])?)?;
    let truth = columns.any_truth.then(|| shaped(py, columns.truth, [ticks, 3]));
    dict.set_item("truth", truth.transpose()?)?;
    let scan_count = columns.scan_ticks.len();
    dict.set_item("scan_ticks", shaped(py, columns.scan_ticks, [scan_count])?)?;
    dict.set_item("ranges", shaped(py, scans_m, scans)?)?;
    let readings = PyDict::new(py);
    for (name, (width, rows)) in columns.readings {
        let shape = [rows.len() / width, width];
        readings.set_item(name, shaped(py, rows, shape)?)?;
    }
    dict.set_item("readings", readings)?;
    let (answers, covariances) = (PyDict::new(py), PyDict::new(py));
    let innovations = PyDict::new(py);
    for one in columns.answers {
        answers.set_item(&one.name, shaped(py, one.poses, [ticks, 3])?)?;
        if let Some(all) = one.covariances {
            covariances.set_item(&one.name, shaped(py, all, [ticks, 3, 3])?)?;
        }
        if let Some(all) = one.innovations {
            innovations.set_item(&one.name, shaped(py, all, [ticks, 2])?)?;
        }
    }
    dict.set_item("answers", answers)?;
    dict.set_item("covariances", covariances)?;
    dict.set_item("innovations", innovations)?;
    dict.set_item("digest", columns.digest.run_hex())?;
    let damaged = columns.damaged_ticks.len();
    dict.set_item("damaged_ticks", shaped(py, columns.damaged_ticks, [damaged])?)?;
    dict.set_item("problem", columns.problem)?;
    Ok(dict)
}

/// What Python raises for it: `FileNotFoundError` and its kin for files,
/// `RustyError` for what is in them.
fn raised(error: LogError) -> PyErr {
    match &error {
        LogError::Io { error: os, .. } => std::io::Error::new(os.kind(), error.to_string()).into(),
        _ => RustyError::new_err(error.to_string()),
    }
}

/// Adds what reads logs to the module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(read_columns, module)?)
}
