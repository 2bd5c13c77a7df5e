//! `Shown`: a file of beliefs that a filter wrote while it worked on a log, for
//! the report on that log.

use std::collections::VecDeque;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use rusty_contract::belief::{BeliefReader, Found, file_name};
use rusty_contract::digest::observable_of;
use rusty_contract::{Frame, LogHeader, errln, input};

use crate::scoring::{BeliefKeeper, BeliefMoment};
use rusty_clients::ClientError;
use rusty_clients::showing::failure;

/// A file that was read, and the frames that its beliefs were held after: ticks
/// with what is observable of their frames.
pub(super) struct Shown {
    path: PathBuf,
    /// Whose beliefs.
    pub(super) name: String,
    /// Whether it was found next to the log, not named on the command line: if it
    /// does not fit, it is left out.
    pub(super) is_found: bool,
    frames: VecDeque<(u64, u64)>,
}

impl Shown {
    /// Reads a file. What is missing at its end is said and no error.
    pub(super) fn read(
        path: &Path,
        scenario: &str,
        keeper: &mut BeliefKeeper,
    ) -> Result<Self, ClientError> {
        let file = input::open(path).map_err(ClientError::io(path))?;
        let mut reader = BeliefReader::new(BufReader::new(file)).map_err(failure(path))?;
        let name = reader.header().name.clone();
        let of = &reader.header().scenario;
        if of != scenario || rusty_contract::names::check_participant_name(&name).is_err() {
            return Err(ClientError::Unusable(format!(
                "{}: beliefs of {name:?} in {of:?}; this log is of {scenario:?}: give those that \
                 were written on this log",
                path.display()
            )));
        }
        let mut frames = VecDeque::new();
        loop {
            match reader.next().map_err(failure(path))? {
                Found::Moment { tick, observable, kind, whole, poses } => {
                    frames.push_back((tick, observable));
                    keeper.offer(&name, BeliefMoment::of(tick, kind, whole, poses));
                }
                Found::End => break,
                Found::Cut => {
                    let (path, n) = (path.display(), frames.len());
                    errln!("{path} ends after {n} beliefs, without the end that a filter writes");
                    break;
                }
            }
        }
        // All of them are here; no later one decides.
        keeper.close(u64::MAX);
        Ok(Self { path: path.to_owned(), name, is_found: false, frames })
    }

    /// Reads those that the scorer of the run left next to its log, but for the
    /// filters of `given`. One that cannot be read is said and left out.
    pub(super) fn find(
        log: &Path,
        header: &LogHeader,
        given: &mut Vec<Self>,
        keeper: &mut BeliefKeeper,
    ) {
        for participant in header.answering() {
            let (name, path) =
                (&participant.name, log.with_file_name(file_name(&participant.name)));
            if given.iter().any(|shown| shown.name == *name) || !path.is_file() {
                continue;
            }
            match Self::read(&path, &header.config.scenario, keeper) {
                Ok(shown) if shown.name == *name => given.push(Self { is_found: true, ..shown }),
                Ok(shown) => keeper.forget(&shown.name),
                Err(e) => {
                    keeper.forget(name);
                    errln!("{e}; it is left out");
                }
            }
        }
    }

    /// Whether each file is of another filter.
    pub(super) fn check_names(all: &[Self]) -> Result<(), ClientError> {
        let twice = |(k, of): (usize, &Self)| {
            all[..k].iter().find(|before| before.name == of.name).map(|before| {
                let (name, a, b) = (&of.name, before.path.display(), of.path.display());
                let text = format!("{a} and {b} are both of {name:?}: give one of them");
                ClientError::Unusable(text)
            })
        };
        all.iter().enumerate().find_map(twice).map_or(Ok(()), Err)
    }

    /// Whether the belief of this frame's tick, if there is one, was held after
    /// this frame.
    pub(super) fn check(&mut self, frame: &Frame) -> Result<(), ClientError> {
        let of_tick = self.frames.front().filter(|(tick, _)| *tick <= frame.tick()).copied();
        let Some((tick, observable)) = of_tick else { return Ok(()) };
        self.frames.pop_front();
        match tick == frame.tick() && observable == observable_of(frame) {
            true => Ok(()),
            false => Err(self.of_another(tick)),
        }
    }

    /// The log is over; `is_whole`: with its end.
    pub(super) fn finish(&self, is_whole: bool) -> Result<(), ClientError> {
        match self.frames.front() {
            Some((tick, _)) if is_whole => Err(self.of_another(*tick)),
            _ => Ok(()),
        }
    }

    fn of_another(&self, tick: u64) -> ClientError {
        let path = self.path.display();
        ClientError::Unusable(format!(
            "{path}: its belief of tick {tick} was held after another frame than the log has; give \
             the file that was written on this log"
        ))
    }
}
