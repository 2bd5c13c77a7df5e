//! How fast a log is written here, compared with what the folder takes at most.
//!
//! The same records three ways, in turn, the best of each counting: as the
//! logger writes them; as one plain file of the same bytes, which is what the
//! folder takes; and encoded to nowhere, which is what the thread of the tick
//! has to do. With `sync` the clock runs until the disk says that it has them,
//! otherwise until the operating system has.

use std::fs::{self, File};
use std::io::{self, BufReader, Seek as _, Write as _};
use std::path::{Path, PathBuf};
use std::time::Instant;

use rusty_contract::frame::MAX_BEAMS;
use rusty_contract::log::{Ending, LogHeader, LogReader, LogWriter, Read, TickRef, Trailer};
use rusty_contract::output::make_folder;
use rusty_contract::{Frame, RunDigest, Scenario, TruthKey};
use rusty_geometry::{EncoderCounts, SE2, Twist};
use serde::Serialize;

use super::behind;
use rusty_clients::ClientError;

/// Bytes per write of the plain file.
const PIECE: usize = 256 << 10;

/// What to measure.
#[derive(Clone, Debug)]
pub struct Measure {
    /// Where to write.
    pub folder: PathBuf,
    /// How many records.
    pub ticks: u64,
    /// Beams of the scan in each of them; none: no scan.
    pub beams: usize,
    /// Number of measurements of each way.
    pub rounds: usize,
    /// Whether the disk has to have them.
    pub sync: bool,
}

/// What was measured. Rates in MB (10⁶ bytes) a second.
#[derive(Clone, Debug, Serialize)]
pub struct Measured {
    /// Records.
    pub ticks: u64,
    /// Beams in each.
    pub beams: usize,
    /// Length of the log, bytes.
    pub bytes: u64,
    /// Length of a record, bytes, on average.
    pub bytes_per_tick: f64,
    /// Whether the disk had to have it.
    pub synced: bool,
    /// As the logger writes.
    pub log_mb_s: f64,
    /// The same bytes as a plain file.
    pub plain_mb_s: f64,
    /// The first of these divided by the second.
    pub log_per_plain: f64,
    /// Encoding alone.
    pub encode_mb_s: f64,
    /// The same for one record, ns.
    pub encode_ns_per_tick: f64,
    /// Run digest over the records; the log was read again and has it.
    pub digest: String,
}

impl Measure {
    /// Measures. Leaves nothing in the folder.
    ///
    /// # Errors
    /// [`ClientError`] names file and reason, also if the log that was written
    /// does not read as it should.
    pub fn run(&self) -> Result<Measured, ClientError> {
        let beams = self.beams;
        if beams > MAX_BEAMS {
            let text = format!("--beams {beams}: a frame has at most {MAX_BEAMS}");
            return Err(ClientError::Unusable(text));
        }
        make_folder(&self.folder).map_err(ClientError::io(&self.folder))?;
        let (mut log_s, mut plain_s, mut encode_s) = (f64::MAX, f64::MAX, f64::MAX);
        let (mut bytes, mut digest) = (0, RunDigest::default());
        for _ in 0..self.rounds.max(1) {
            encode_s = encode_s.min(self.encode()?);
            let mut log = Nameless::in_folder(&self.folder)?;
            log_s = log_s.min(self.write_log(&log)?);
            (bytes, digest) = self.read_again(&mut log)?;
            drop(log);
            let plain = Nameless::in_folder(&self.folder)?;
            plain_s = plain_s.min(self.write_plain(&plain, bytes)?);
        }
        let rate = |seconds: f64| bytes as f64 / 1e6 / seconds;
        Ok(Measured {
            ticks: self.ticks,
            beams,
            bytes,
            bytes_per_tick: bytes as f64 / self.ticks.max(1) as f64,
            synced: self.sync,
            log_mb_s: rate(log_s),
            plain_mb_s: rate(plain_s),
            log_per_plain: plain_s / log_s,
            encode_mb_s: rate(encode_s),
            encode_ns_per_tick: 1e9 * encode_s / self.ticks.max(1) as f64,
            digest: digest.run_hex(),
        })
    }

    /// Hands every record to `each`.
    fn records(&self, mut each: impl FnMut(TickRef<'_>) -> Result<(), ClientError>) -> Done {
        let mut frame = Frame::boxed();
        let dt_s = 0.02;
        for tick in 0..self.ticks {
            let turn = tick as i64;
            let ticks = EncoderCounts { left: 40 * turn, right: 41 * turn };
            let command = Twist { v_m_s: 0.5, omega_rad_s: 0.1 };
            frame.begin(tick, (tick + 1) as f64 * dt_s, ticks, command);
            if self.beams > 0 {
                let scan = frame.write_scan(self.beams);
                if tick == 0 {
                    scan.iter_mut().zip(0u32..).for_each(|(r, k)| *r = 0.5 + f64::from(k) * 1e-3);
                }
                scan[tick as usize % self.beams] = 0.25;
            }
            let here = SE2::new(tick as f64 * 1e-3, 1.0, 0.5);
            each(TickRef::new(&frame, Some(here), &[here.into()], dt_s))?;
        }
        Ok(())
    }

    /// Each way gives the seconds that it took.
    fn encode(&self) -> Result<f64, ClientError> {
        let mut writer = LogWriter::new(io::sink(), Path::new("nowhere"), &header(self.ticks))?;
        let begin = Instant::now();
        self.records(|record| Ok(writer.tick(record)?))?;
        Ok(begin.elapsed().as_secs_f64())
    }

    fn write_log(&self, to: &Nameless) -> Result<f64, ClientError> {
        let begin = Instant::now();
        let file = to.file.try_clone().map_err(ClientError::io(&to.path))?;
        let mut writer = behind(file, &to.path, &header(self.ticks))?;
        self.records(|record| Ok(writer.tick(record)?))?;
        let ticks = self.ticks;
        writer.finish(Trailer { ticks, run_digest: [0; 16], world_digest: [0; 16] })?;
        self.synced(to)?;
        Ok(begin.elapsed().as_secs_f64())
    }

    fn write_plain(&self, to: &Nameless, bytes: u64) -> Result<f64, ClientError> {
        let piece = vec![0x5A; PIECE];
        let begin = Instant::now();
        let mut left = bytes;
        while left > 0 {
            let n = left.min(PIECE as u64);
            (&to.file).write_all(&piece[..n as usize]).map_err(ClientError::io(&to.path))?;
            left -= n;
        }
        self.synced(to)?;
        Ok(begin.elapsed().as_secs_f64())
    }

    fn synced(&self, file: &Nameless) -> Done {
        if self.sync {
            file.file.sync_data().map_err(ClientError::io(&file.path))?;
        }
        Ok(())
    }

    /// Length and digest of a log that must be complete.
    fn read_again(&self, log: &mut Nameless) -> Result<(u64, RunDigest), ClientError> {
        let io = |error| ClientError::Io { path: log.path.display().to_string(), error };
        let bytes = log.file.metadata().map_err(io)?.len();
        log.file.rewind().map_err(io)?;
        let input = BufReader::with_capacity(PIECE, &log.file);
        let mut reader = LogReader::new(input, &log.path.display().to_string())?;
        let (mut frame, key) = (Frame::boxed(), TruthKey::from_bytes([0; 32]));
        let mut digest = RunDigest::default();
        let dt_s = reader.header().config.dt_s;
        loop {
            match reader.read()? {
                Read::Tick(entry) => {
                    entry.record.write_frame(&mut frame, dt_s, &key);
                    entry.record.absorb(&frame, &mut digest);
                }
                Read::End(Ending::Complete(trailer))
                    if trailer.ticks == self.ticks && reader.damaged() == 0 =>
                {
                    return Ok((bytes, digest));
                }
                Read::End(ending) => {
                    let text = format!("{}: it reads as {ending:?}", log.path.display());
                    return Err(ClientError::Unusable(text));
                }
            }
        }
    }
}

type Done = Result<(), ClientError>;

/// A file that has lost its name: whatever happens, nothing of it stays.
struct Nameless {
    file: File,
    path: PathBuf,
}

impl Nameless {
    fn in_folder(folder: &Path) -> Result<Self, ClientError> {
        let path = folder.join(format!("measure-{}", std::process::id()));
        let mut options = File::options();
        let made = options.read(true).write(true).create_new(true).open(&path);
        let file = made.map_err(ClientError::io(&path))?;
        fs::remove_file(&path).map_err(ClientError::io(&path))?;
        Ok(Self { file, path })
    }
}

pub(super) fn header(ticks: u64) -> LogHeader {
    let scenario = Scenario { ticks: ticks.max(1), scan_every: 1, ..Scenario::default() };
    let writer = concat!("logger ", env!("CARGO_PKG_VERSION"), " measure");
    LogHeader::simulated(writer, &scenario, rusty_geometry::apartment().spec().clone())
}

impl std::fmt::Display for Measured {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (ticks, beams, per_tick) = (self.ticks, self.beams, self.bytes_per_tick);
        let megabytes = self.bytes as f64 / 1e6;
        writeln!(f, "{ticks} ticks of {beams} beams: {megabytes:.1} MB, {per_tick:.1} B a tick")?;
        let (log, plain, ratio) = (self.log_mb_s, self.plain_mb_s, self.log_per_plain);
        let whose = if self.synced { "on the disk" } else { "with the system" };
        writeln!(f, "log       {log:8.0} MB/s, {ratio:.2} of a plain file ({whose})")?;
        writeln!(f, "plain     {plain:8.0} MB/s")?;
        let (encode, each) = (self.encode_mb_s, self.encode_ns_per_tick);
        writeln!(f, "encoding  {encode:8.0} MB/s, {each:.0} ns a tick")?;
        write!(f, "digest    {} (read again: complete)", self.digest)
    }
}
