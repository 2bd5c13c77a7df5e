//! Bringing a lost participant back: start its program, give it the run again.

use rusty_contract::answer::Message;
use rusty_contract::tally::TallyEntry;
use rusty_contract::{Answer, CatchUp, Reply};
use rusty_link::{Feed, LinkError};

use super::Run;
use super::ledger::Chain;
use crate::lockstep::Loss;
use crate::source::FrameSource;

/// The run again, for one who missed it.
pub(super) struct Feeding {
    feed: Feed,
    source: Box<dyn FrameSource>,
    /// The digests and effects then.
    chain: Chain,
    /// It has been said that this one does not repeat itself.
    differs: bool,
}

impl Run<'_> {
    /// Starts the program of a lost participant once more.
    pub(super) fn bring_back(&mut self, loss: Loss) {
        let (slot, name) = (loss.slot, loss.name.clone());
        let output = self.participants.output(slot);
        self.progress.say(&format!("lost: {loss}{output}"));
        self.progress.say(&format!("{name} is started again; the run waits for it"));
        self.participants.peers[slot] = None;
        self.participants.feedings[slot] = None;
        let link = &self.wire.link;
        match self.participants.children.restart(slot, || link.forget_the_dead()) {
            Ok(true) => {}
            Ok(false) => {
                self.wire.link.forget_the_dead();
                let seconds = self.participants.join_timeout_s;
                self.progress.say(&format!(
                    "{name} was started by hand: start it again, within {seconds} s"
                ));
            }
            // That it does not come back shows when its time is over.
            Err(e) => self.progress.say(&e.to_string()),
        }
        self.pacer.stand_still();
        self.progress.waits();
        self.ledger.restarts.push(loss);
    }

    /// Prepares to give `slot` what it missed, if anything.
    pub(super) fn catch_up(&mut self, slot: usize) -> Result<Option<CatchUp>, LinkError> {
        let place = &self.lockstep.slots()[slot];
        let Some(ticks) = place.catch_up.map(|c| c.ticks).filter(|ticks| *ticks > 0) else {
            return Ok(None);
        };
        // The services of earlier runs may still be open.
        let service = format!("again-{}-{slot}-{}", self.identity.run_number, place.restarts);
        let source = match self.source.again() {
            Ok(source) => source,
            Err(e) => {
                self.end_for(e);
                return Ok(None);
            }
        };
        self.participants.feedings[slot] = Some(Feeding {
            feed: self.wire.link.feed(&service, slot)?,
            source,
            chain: Chain::new(self.identity.run_id, self.source.header()),
            differs: false,
        });
        Ok(Some(CatchUp { ticks, service }))
    }

    /// Gives `slot` the next tick it missed.
    pub(super) fn feed(&mut self, slot: usize, tick: u64) -> Result<(), LinkError> {
        let Some(feeding) = &mut self.participants.feedings[slot] else {
            // A participant that has to catch up was given a feed when it joined.
            self.lockstep.abort();
            return Ok(());
        };
        let mut frame = feeding.feed.loan()?;
        let truth = match feeding.source.make(feeding.chain.effects.command(), &mut frame) {
            Ok(truth) => truth,
            Err(e) => {
                self.end_for(e);
                return Ok(());
            }
        };
        frame.run_id = self.identity.run_id;
        frame.seal(&self.identity.key, truth);
        feeding.chain.frame(&frame, truth);
        let digest = frame.digest();
        let now = feeding.feed.publish(frame)?;
        if let Some(replies) = self.ledger.replies(tick) {
            feeding.close(tick, &replies, self.lockstep.answering())?;
        }
        self.lockstep.fed(slot, digest, now);
        self.wire.link.stay_awake(now);
        let place = &self.lockstep.slots()[slot];
        self.wire.link.wake_sleepers(std::iter::once((place.waiting_since_ns, place.awake_ns)));
        Ok(())
    }

    /// Compares what one who came back says with what it had said.
    pub(super) fn echo(&mut self, slot: usize, tick: u64, reply: Reply) {
        let place = &self.lockstep.slots()[slot];
        let Some(i) = self.lockstep.answering().iter().position(|&i| i == slot) else { return };
        let before = match self.ledger.replies(tick) {
            Some(replies) => replies.get(i).copied(),
            None => place.reply,
        };
        let differs = before.is_some_and(|before| !before.same_bits(&reply));
        if let Some(feeding) =
            self.participants.feedings[slot].as_mut().filter(|f| differs && !f.differs)
        {
            feeding.differs = true;
            let remark = format!(
                "{} came back and answers tick {tick} otherwise than before: it depends on more \
                 than the run (a clock, a random number, a file), so this run cannot be repeated",
                place.name
            );
            self.progress.say(&remark);
            self.ledger.remarks.push(remark);
        }
    }
}

impl Feeding {
    /// The answers to a tick that all others have closed long ago. How long
    /// they took is not given again.
    fn close(
        &mut self,
        tick: u64,
        replies: &[Reply],
        answering: &[usize],
    ) -> Result<(), LinkError> {
        self.chain.close(tick, replies.iter().copied());
        let chain = &self.chain;
        self.feed.publish_tally(|tally| {
            chain.begin_tally(tally, tick);
            for (&slot, &reply) in answering.iter().zip(replies) {
                tally.push(if reply == Reply::Missing {
                    TallyEntry::missing(slot as u32)
                } else {
                    let mut answer = Answer::carrying(&Message::Reply(reply));
                    (answer.run_id, answer.tick) = (tally.run_id, tick);
                    answer.participant = slot as u32;
                    TallyEntry::answered(answer, 0)
                });
            }
        })
    }
}
