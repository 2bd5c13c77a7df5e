//! What a server and a client do in a tick: the same for everyone compared.
//!
//! The server's half is that of `sim-server` around its transport: the world
//! moves by a tick, the frame is sealed, the run's digest absorbs it, answers
//! are checked and absorbed. The client's half is the client `dead-reckoning`.
//! So a run has the same digest for all transports, and that digest is the one
//! of `sim-server launch`.

use rusty_clients::dead_reckoning::DeadReckoning;
use rusty_contract::answer::Message;
use rusty_contract::{Answer, Frame, Phase, Reply, RunConfig, RunDigest, TruthKey};
use rusty_engine::scenario_file;
use rusty_link::monotonic_ns;
use rusty_sim::Sim;

use crate::error::BenchError;

/// The configuration of every run here: the apartment, with the scans of its
/// scenario or with none.
pub fn config(ticks: u64, scans: bool) -> Result<RunConfig, BenchError> {
    let mut changes = vec![format!("ticks={ticks}")];
    if !scans {
        changes.push("scan_every=0".to_owned());
    }
    Ok(scenario_file::load("apartment", &changes)?.config()?)
}

pub struct World {
    sim: Sim,
    key: TruthKey,
    run_id: u64,
    digest: RunDigest,
    /// The digest of the frame that is out.
    frame_digest: u64,
    tick: u64,
    replies: Vec<Option<Reply>>,
}

impl World {
    /// The world before its first tick, with N clients.
    pub fn new(config: RunConfig, clients: usize) -> Result<Self, BenchError> {
        Ok(Self {
            sim: Sim::new(config)?,
            key: TruthKey::from_bytes([7; 32]),
            run_id: u64::from(std::process::id()),
            digest: RunDigest::default(),
            frame_digest: 0,
            tick: 0,
            replies: vec![None; clients],
        })
    }

    /// Moves by a tick and writes it into `frame`, ready to be sent.
    pub fn write(&mut self, frame: &mut Frame) {
        self.tick = self.sim.tick();
        let _ = self.sim.step(None, frame);
        let truth = Some(self.sim.truth());
        frame.run_id = self.run_id;
        frame.seal(&self.key, truth);
        frame.published_ns = monotonic_ns();
        self.digest.absorb_frame(frame, truth);
        self.frame_digest = frame.digest();
        self.replies.fill(None);
    }

    pub fn end(&self, frame: &mut Frame) {
        frame.end(Phase::Done, self.sim.tick());
        frame.run_id = self.run_id;
    }

    /// Takes an answer to the frame that is out.
    pub fn take(&mut self, answer: &Answer) -> Result<(), BenchError> {
        let (tick, place) = (self.tick, answer.participant);
        let wrong =
            |problem: &str| Err(BenchError::Answer { tick, place, problem: problem.to_owned() });
        if answer.run_id != self.run_id {
            return wrong("is of another run");
        }
        if answer.tick != tick {
            return wrong(&format!("is to tick {}", answer.tick));
        }
        if answer.digest_seen != self.frame_digest {
            return wrong("saw another frame");
        }
        let message = answer.message().map_err(|error| BenchError::Number { tick, error })?;
        let Message::Reply(reply) = message else { return wrong("is no reply") };
        match self.replies.get_mut(place as usize) {
            Some(slot @ None) => *slot = Some(reply),
            Some(Some(_)) => return wrong("came twice"),
            None => return wrong("has no place here"),
        }
        Ok(())
    }

    pub fn is_complete(&self) -> bool {
        self.replies.iter().all(Option::is_some)
    }

    pub fn close(&mut self) {
        let replies = self.replies.iter().map(|reply| reply.unwrap_or_default());
        self.digest.absorb_replies(replies);
    }

    /// The run's digest so far, in hexadecimal digits.
    pub fn digest(&self) -> String {
        self.digest.run_hex()
    }
}

pub struct Mind {
    reckoning: DeadReckoning,
    place: u32,
    expected: u64,
}

impl Mind {
    /// A client before its first frame.
    pub fn new(config: &RunConfig, place: u32) -> Self {
        let drive = config.robot.nominal().drive;
        Self { reckoning: DeadReckoning::new(drive, config.start), place, expected: 0 }
    }

    /// What it says before the first frame.
    pub fn ready(place: u32) -> Answer {
        let mut answer = Answer::carrying(&Message::Ready);
        answer.participant = place;
        answer
    }

    /// What it says to a frame; nothing to the end of run.
    pub fn answer(&mut self, frame: &Frame) -> Result<Option<Answer>, BenchError> {
        let taken_ns = monotonic_ns();
        if frame.phase() != Phase::Tick {
            return Ok(None);
        }
        let (place, tick, expected) = (self.place, frame.tick(), self.expected);
        if tick != expected {
            return Err(BenchError::Frame { place, tick, expected });
        }
        self.expected += 1;
        let reply = Reply::from(self.reckoning.advance(frame.encoders()));
        reply.check().map_err(|error| BenchError::Number { tick, error })?;
        let mut answer = Answer::carrying(&Message::Reply(reply));
        answer.run_id = frame.run_id;
        answer.tick = tick;
        answer.digest_seen = frame.digest();
        answer.participant = place;
        answer.sent_ns = monotonic_ns();
        answer.compute_ns = answer.sent_ns.saturating_sub(taken_ns);
        Ok(Some(answer))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn played(ticks: u64, scans: bool) -> String {
        let config = config(ticks, scans).unwrap();
        let mut world = World::new(config.clone(), 2).unwrap();
        let mut minds = [Mind::new(&config, 0), Mind::new(&config, 1)];
        let mut frame = Frame::boxed();
        for _ in 0..ticks {
            world.write(&mut frame);
            assert!(!world.is_complete());
            // The order in which answers come does not matter.
            for mind in minds.iter_mut().rev() {
                let answer = mind.answer(&frame).unwrap().unwrap();
                world.take(&answer).unwrap();
            }
            assert!(world.is_complete());
            world.close();
        }
        world.digest()
    }

    #[test]
    fn the_same_run_has_the_same_digest_and_scans_change_it() {
        assert_eq!(played(50, false), played(50, false));
        assert_ne!(played(50, false), played(50, true));
    }

    #[test]
    fn an_answer_that_is_none_is_refused() {
        let config = config(10, false).unwrap();
        let mut world = World::new(config.clone(), 1).unwrap();
        let mut mind = Mind::new(&config, 0);
        let mut frame = Frame::boxed();
        world.write(&mut frame);
        let good = mind.answer(&frame).unwrap().unwrap();
        let refused = |world: &mut World, answer: Answer| world.take(&answer).unwrap_err();
        let mut spoiled = [good; 4];
        spoiled[0].run_id = 0;
        spoiled[1].tick = 9;
        spoiled[2].digest_seen = 0;
        spoiled[3].participant = 1;
        let words = ["another run", "tick 9", "another frame", "no place"];
        for (answer, word) in spoiled.into_iter().zip(words) {
            assert!(refused(&mut world, answer).to_string().contains(word), "{word}");
        }
        world.take(&good).unwrap();
        assert!(refused(&mut world, good).to_string().contains("twice"));
    }

    #[test]
    fn a_client_notices_a_frame_out_of_turn_and_the_end_of_run() {
        let config = config(10, false).unwrap();
        let mut world = World::new(config.clone(), 1).unwrap();
        let mut mind = Mind::new(&config, 0);
        let mut frame = Frame::boxed();
        world.write(&mut frame);
        world.write(&mut frame);
        assert!(mind.answer(&frame).unwrap_err().to_string().contains("frame 1"));
        world.end(&mut frame);
        assert!(mind.answer(&frame).unwrap().is_none());
    }
}
