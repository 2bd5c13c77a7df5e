//! A session on a log: the same frames, no server.
//!
//! An estimator's answers go to a CSV file or stdout, and are compared with
//! those that a participant of the same name gave when the log was recorded.

use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::rc::Rc;

use rusty_contract::digest::ObservableDigest;
use rusty_contract::log::{Ending, LogError, LogReader, Read};
use rusty_contract::{
    BlindKey, BlindKeyError, Brief, Frame, Json as _, LogHeader, Participant, Reply, Role, Start,
    TruthKey, errln,
};

use crate::ClientError;

/// A session on a log.
pub(crate) struct LogSession {
    path: PathBuf,
    reader: LogReader,
    /// What a blind log lacks, and the number of the next tick.
    unblinded: Option<(BlindKey, u64)>,
    start: Start,
    key: TruthKey,
    frame: Rc<Frame>,
    replies: Vec<Reply>,
    /// Place of this participant among the recorded replies.
    place: Option<usize>,
    answers: Answers,
    equal: u64,
    compared: u64,
    cut: Option<String>,
}

/// Why a key does not unblind a log.
enum Unfit {
    Key(BlindKeyError),
    Log(LogError),
}

/// Where an estimator's answers go.
struct Answers {
    /// The file; `None` for stdout.
    path: Option<PathBuf>,
    /// Opened with the first answer.
    out: Option<Box<dyn Write>>,
}

impl Answers {
    /// Writes one line, after the header if it is the first.
    fn line(&mut self, line: &str) -> Result<(), ClientError> {
        if self.out.is_none() {
            let mut out = self.open()?;
            let written = writeln!(out, "tick,time_s,x_m,y_m,theta_rad,v_m_s,omega_rad_s");
            self.out = Some(out);
            self.check(written)?;
        }
        let written = self.out.as_mut().map_or(Ok(()), |out| writeln!(out, "{line}"));
        self.check(written)
    }

    fn flush(&mut self) -> Result<(), ClientError> {
        let written = self.out.as_mut().map_or(Ok(()), |out| out.flush());
        self.check(written)
    }

    fn open(&self) -> Result<Box<dyn Write>, ClientError> {
        Ok(match &self.path {
            Some(path) => {
                let file = std::fs::File::create(path).map_err(ClientError::io(path))?;
                Box::new(BufWriter::new(file))
            }
            None => Box::new(BufWriter::new(std::io::stdout())),
        })
    }

    fn check(&mut self, written: std::io::Result<()>) -> Result<(), ClientError> {
        let Err(error) = written else { return Ok(()) };
        // A reader that has seen enough (`… | head`) is no failure.
        if error.kind() == std::io::ErrorKind::BrokenPipe {
            self.out = Some(Box::new(std::io::sink()));
            return Ok(());
        }
        Err(match &self.path {
            Some(path) => ClientError::io(path)(error),
            None => ClientError::Stdout(error),
        })
    }
}

impl LogSession {
    pub(crate) fn open(log: &Path, name: &str, out: Option<&Path>) -> Result<Self, ClientError> {
        let reader = LogReader::open(log)?;
        let header = reader.header();
        let place = header.answering().position(|p| p.name == name);
        // A process that can read the file can read its truth. The seal keeps one way
        // of reading frames for runs and logs, no secret.
        let key = TruthKey::from_bytes([0x5A; 32]);
        let start = start(header, name, &key);
        Ok(Self {
            path: log.to_owned(),
            unblinded: None,
            start,
            key,
            frame: Rc::from(Frame::boxed()),
            replies: Vec::new(),
            place,
            answers: Answers { path: out.map(Path::to_owned), out: None },
            equal: 0,
            compared: 0,
            cut: None,
            reader,
        })
    }

    /// Takes the truth of a blind log from its key: checks that each frame is
    /// the key's, and gives the header as it was before sealing, with the
    /// roster of this log.
    pub(crate) fn unblind(&mut self, file: &Path) -> Result<LogHeader, ClientError> {
        let header = self.reader.header();
        if !header.is_blind() {
            let log = self.path.display();
            let text = format!("{log} is not blind: it has its own truth; leave --key-file out");
            return Err(ClientError::Unusable(text));
        }
        let path = file.display().to_string();
        let bytes = rusty_contract::input::read(file).map_err(ClientError::io(file))?;
        let error = |error| ClientError::BlindKey { path: path.clone(), error };
        let key = BlindKey::from_bytes(&bytes).map_err(error)?;
        let ticks = self.check_frames(&key).map_err(|e| match e {
            Unfit::Key(e) => error(e),
            Unfit::Log(e) => e.into(),
        })?;
        let all = key.ticks.len() as u64;
        if ticks < all {
            let text = format!("the log has {ticks} of the {all} ticks of its key");
            errln!("{text}");
            self.cut = Some(text);
        }
        let (roster, on_loss) = (header.roster.clone(), header.on_loss);
        let header = LogHeader { roster, on_loss, ..key.header.clone() };
        self.unblinded = Some((key, 0));
        Ok(header)
    }

    /// How many ticks the log has, if all its frames are those of the key.
    fn check_frames(&self, key: &BlindKey) -> Result<u64, Unfit> {
        let mut reader = LogReader::open(&self.path).map_err(Unfit::Log)?;
        let (mut frame, mut digest) = (Frame::boxed(), ObservableDigest::default());
        let mut tick = 0;
        while let Read::Tick(entry) = reader.read().map_err(Unfit::Log)? {
            entry.record.write_unsealed(&mut frame, self.start.dt_s);
            let _ = key.truth_of(tick, &frame).map_err(Unfit::Key)?;
            digest.absorb(&frame);
            tick += 1;
        }
        if tick == key.ticks.len() as u64 && digest.value() != key.observable_digest {
            let problem = "its observable digest is not that of its ticks".to_owned();
            return Err(Unfit::Key(BlindKeyError::Content(problem)));
        }
        Ok(tick)
    }

    pub(crate) fn start(&self) -> &Start {
        &self.start
    }

    pub(crate) fn key(&self) -> &TruthKey {
        &self.key
    }

    pub(crate) fn recorded_replies(&self) -> &[Reply] {
        &self.replies
    }

    /// Whether the log lacks its end, or a record is not what was written.
    pub(crate) fn is_broken(&self) -> bool {
        self.cut.is_some() || self.reader.damaged() > 0
    }

    pub(crate) fn next(&mut self) -> Result<Option<Rc<Frame>>, ClientError> {
        match self.reader.read()? {
            Read::Tick(entry) => {
                if !entry.intact {
                    let tick = entry.record.tick;
                    errln!("tick {tick}: the record's checksum fails; its values are suspect");
                }
                // A frame that is still held stays with its holder.
                if Rc::get_mut(&mut self.frame).is_none() {
                    self.frame = Rc::from(Frame::boxed());
                }
                let mut record = entry.record;
                if let Some(frame) = Rc::get_mut(&mut self.frame) {
                    if let Some((key, tick)) = &mut self.unblinded {
                        record.write_unsealed(frame, self.start.dt_s);
                        let path = self.path.display().to_string();
                        let changed = |error| ClientError::BlindKey { path, error };
                        record.truth = key.truth_of(*tick, frame).map_err(changed)?;
                        *tick += 1;
                    }
                    record.write_frame(frame, self.start.dt_s, &self.key);
                }
                self.replies = record.replies;
                Ok(Some(Rc::clone(&self.frame)))
            }
            Read::End(Ending::Complete(_)) => self.end(),
            Read::End(Ending::Cut { ticks, at_byte, problem }) => {
                let text = format!("the log ends after {ticks} ticks (byte {at_byte}): {problem}");
                errln!("{text}");
                self.cut = Some(text);
                self.end()
            }
        }
    }

    fn end(&mut self) -> Result<Option<Rc<Frame>>, ClientError> {
        self.answers.flush()?;
        if self.compared > 0 {
            let (equal, compared) = (self.equal, self.compared);
            errln!("{equal} of {compared} answers equal the recorded ones, bit for bit");
        }
        Ok(None)
    }

    pub(crate) fn reply(&mut self, frame: &Frame, reply: Reply) -> Result<(), ClientError> {
        if let Some(recorded) = self.place.and_then(|i| self.replies.get(i)) {
            self.compared += 1;
            self.equal += u64::from(recorded.same_bits(&reply));
        }
        if reply == Reply::Taken {
            return Ok(());
        }
        let pose = reply.estimate().map(|e| e.pose_in_world);
        let command = reply.command();
        let number = |value: Option<f64>| value.map_or(String::new(), |v| format!("{v:?}"));
        let line = format!(
            "{},{:?},{},{},{},{},{}",
            frame.tick(),
            frame.time_s(),
            number(pose.map(|p| p.x())),
            number(pose.map(|p| p.y())),
            number(pose.map(|p| p.theta())),
            number(command.map(|c| c.v_m_s)),
            number(command.map(|c| c.omega_rad_s)),
        );
        self.answers.line(&line)
    }
}

/// What the participant `name` would be told: its own rights if the log's
/// roster has it, the usual ones otherwise.
fn start(header: &LogHeader, name: &str, key: &TruthKey) -> Start {
    let slot = header.roster.iter().position(|p| p.name == name);
    let participant = slot
        .map(|i| header.roster[i].clone())
        .unwrap_or_else(|| Participant::new(name, Role::Estimator));
    // A process that can read the file can read its header, so the brief is for all.
    let brief = Brief { header: header.clone(), out_dir: None, report: true };
    let json = brief.to_json().unwrap_or_default();
    Start {
        server_pid: std::process::id(),
        sealed_brief: Some(key.seal_brief(0, &json)),
        ..Start::new(header, slot.unwrap_or(header.roster.len()), &participant)
    }
}
