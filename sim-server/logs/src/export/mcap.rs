//! All ticks of a log as messages of ROS 2 in one MCAP file.
//!
//! Source: the MCAP specification (mcap.dev/spec) and its registry: profile `ros2`,
//! schemas `ros2msg`, messages `cdr`. Chunks are not compressed, so that one log gives
//! the same bytes on every machine.

use std::collections::BTreeMap;
use std::io::{Seek, Write};
use std::path::Path;
use std::sync::atomic::AtomicBool;

use mcap::records::{MessageHeader, Metadata};
use mcap::{McapError, WriteOptions, Writer};
use rusty_contract::digest::hex;
use rusty_contract::log::Finding;
use rusty_contract::suggest;
use rusty_contract::{Estimate, LogHeader};
use rusty_ros::{Channel, Description, Encoder, Tick};
use serde::Serialize;

use super::error::ExportError;
use super::sheet::Sheet;
use super::walk::{Walk, Walked, truth};

/// Program and version in the file.
const LIBRARY: &str = concat!("sim-server ", env!("CARGO_PKG_VERSION"));
/// The participant's name that leaves the frame `odom` without a parent.
pub const NO_ESTIMATOR: &str = "none";

/// The messages that are written.
#[derive(Clone, Debug, Default)]
pub struct RosOptions {
    /// Whose estimates move `odom` in `map`: a participant, or [`NO_ESTIMATOR`]; `None`:
    /// the first that answers.
    pub estimator: Option<String>,
    /// True poses are written.
    pub truth: bool,
    /// Over a file or folder that is there.
    pub force: bool,
}

/// What an export came to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RosExported {
    /// The log.
    pub log: String,
    /// Where its ticks ended.
    #[serde(flatten)]
    pub walked: Walked,
    /// The topics, in the order of their channels.
    pub topics: Vec<Topic>,
    /// Time of the first and of the last message, ns.
    pub span_ns: Option<[u64; 2]>,
    /// Defects of the recording that the log was made from.
    pub findings: Vec<Finding>,
    /// File or folder that was written.
    pub path: String,
}

/// A topic that was written.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Topic {
    /// Its name.
    pub name: String,
    /// Type of its messages.
    #[serde(rename = "type")]
    pub type_name: &'static str,
    /// Quality of service, as rosbag2 writes it.
    #[serde(skip)]
    pub qos: String,
    /// Number of messages.
    pub messages: u64,
}

impl RosExported {
    /// Number of all messages.
    #[must_use]
    pub fn messages(&self) -> u64 {
        self.topics.iter().map(|topic| topic.messages).sum()
    }
}

/// Writes the ticks of `log` to the file `out`.
///
/// # Errors
/// [`ExportError`]; nothing is written then.
pub fn export(
    log: &Path,
    out: &Path,
    options: &RosOptions,
    stop: &AtomicBool,
) -> Result<RosExported, ExportError> {
    let mut walk = Walk::open(log, stop)?;
    let about = description(&walk.header, log, options)?;
    let mut encoder = Encoder::new(about);
    let mut sheet = Sheet::create(out, options.force)?;
    let failed = ExportError::mcap(out);
    let writer = WriteOptions::new().compression(None).profile("ros2").library(LIBRARY);
    let writer = writer.create(sheet.out()).map_err(&failed)?;
    let mut writer = Messages { writer, ids: Vec::new(), counts: Vec::new(), span_ns: None };
    writer.add_channels(encoder.channels()).map_err(&failed)?;
    let (dt_s, has_truth) = (walk.header.config.dt_s, options.truth);
    while let Some(record) = walk.tick()? {
        let estimates: Vec<Option<Estimate>> = walk.estimates().collect();
        let encoded = encoder.tick(&Tick {
            time_s: record.time_s(dt_s),
            counts: record.ticks,
            command: record.command,
            ranges_m: record.ranges_m.as_deref(),
            readings: record.readings.get(),
            truth: truth(&record).filter(|_| has_truth),
            estimates: &estimates,
        });
        let encoded = encoded.map_err(|e| ExportError::Ros(log.display().to_string(), e))?;
        for message in encoded {
            writer.write(&message).map_err(&failed)?;
        }
    }
    let (counts, span_ns) = writer.finish(&metadata(&walk)).map_err(&failed)?;
    let topic = |(channel, messages): (&Channel, u64)| Topic {
        name: channel.topic.clone(),
        type_name: channel.type_name,
        qos: channel.qos(),
        messages,
    };
    Ok(RosExported {
        log: log.display().to_string(),
        walked: walk.walked.clone(),
        topics: encoder.channels().iter().zip(counts).map(topic).collect(),
        span_ns,
        findings: walk.header.findings().to_vec(),
        path: sheet.finish()?,
    })
}

/// Returns what the messages tell of the run.
fn description(
    header: &LogHeader,
    log: &Path,
    options: &RosOptions,
) -> Result<Description, ExportError> {
    if options.truth && header.is_blind() {
        return Err(ExportError::NoTruth(log.display().to_string()));
    }
    let mut about = Description { truth: options.truth, ..Description::of(header) };
    if let Some(name) = options.estimator.as_ref() {
        about.localizer = about.estimators.iter().position(|known| known == name);
        if about.localizer.is_none() && name != NO_ESTIMATOR {
            let names = about.estimators.iter().map(String::as_str);
            return Err(ExportError::NoEstimator {
                log: log.display().to_string(),
                name: name.clone(),
                hint: suggest::did_you_mean(name, names),
                known: about.estimators.join(", "),
            });
        }
    }
    Ok(about)
}

/// A file of messages that is being written.
struct Messages<W: Write + Seek> {
    writer: Writer<W>,
    /// Number of each channel in the file.
    ids: Vec<u16>,
    /// Messages of each channel.
    counts: Vec<u64>,
    span_ns: Option<[u64; 2]>,
}

impl<W: Write + Seek> Messages<W> {
    fn add_channels(&mut self, channels: &[Channel]) -> Result<(), McapError> {
        for channel in channels {
            let text = channel.schema();
            let schema = self.writer.add_schema(channel.type_name, "ros2msg", text.as_bytes())?;
            let qos = BTreeMap::from([("offered_qos_profiles".to_owned(), channel.qos())]);
            self.ids.push(self.writer.add_channel(schema, &channel.topic, "cdr", &qos)?);
        }
        self.counts = vec![0; channels.len()];
        Ok(())
    }

    fn write(&mut self, message: &rusty_ros::Encoded<'_>) -> Result<(), McapError> {
        let (count, time_ns) = (&mut self.counts[message.channel], message.time_ns);
        let header = MessageHeader {
            channel_id: self.ids[message.channel],
            sequence: *count as u32,
            log_time: time_ns,
            publish_time: time_ns,
        };
        *count += 1;
        let [first, last] = self.span_ns.unwrap_or([time_ns; 2]);
        self.span_ns = Some([first.min(time_ns), last.max(time_ns)]);
        self.writer.write_to_known_channel(&header, message.cdr)
    }

    /// Completes the file; returns the messages of each channel, and their time span.
    fn finish(mut self, metadata: &Metadata) -> Result<(Vec<u64>, Option<[u64; 2]>), McapError> {
        self.writer.write_metadata(metadata)?;
        self.writer.finish()?;
        Ok((self.counts, self.span_ns))
    }
}

/// Returns what the file tells of its run. A blind log has no seed.
fn metadata(walk: &Walk<'_>) -> Metadata {
    let header = &walk.header;
    let mut pairs = vec![
        ("scenario", header.config.scenario.clone()),
        ("writer", header.writer.clone()),
        ("dt_s", format!("{:?}", header.config.dt_s)),
        ("ticks", walk.walked.ticks.to_string()),
    ];
    pairs.extend(header.seed().map(|seed| ("seed", seed.to_string())));
    if let Some(trailer) = &walk.trailer {
        pairs.push(("run_digest", hex(&trailer.run_digest)));
        pairs.push(("world_digest", hex(&trailer.world_digest)));
    }
    let findings: Vec<String> = header.findings().iter().map(ToString::to_string).collect();
    if !findings.is_empty() {
        pairs.push(("findings", findings.join("; ")));
    }
    let metadata = pairs.into_iter().map(|(name, text)| (name.to_owned(), text)).collect();
    Metadata { name: "rusty".to_owned(), metadata }
}
