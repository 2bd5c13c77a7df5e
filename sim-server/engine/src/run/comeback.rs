//! Bringing a lost participant back: start its program, give it the run again.

use rusty_contract::answer::Message;
use rusty_contract::tally::TallyEntry;
use rusty_contract::{Answer, CatchUp, Effects, Reply, RunDigest};
use rusty_link::{Feed, LinkError};

use super::Run;
use crate::lockstep::Loss;
use crate::source::FrameSource;

/// The run again, for one who missed it.
pub(super) struct Feeding {
    feed: Feed,
    source: Box<dyn FrameSource>,
    /// Which answers were in effect then.
    effects: Effects,
    digest: RunDigest,
    /// It has been said that this one does not repeat itself.
    differs: bool,
}

impl Run<'_> {
    /// Starts the program of a lost participant once more.
    pub(super) fn bring_back(&mut self, loss: Loss) {
        let (seat, name) = (loss.seat, loss.name.clone());
        let output = self.output(seat);
        self.progress.say(&format!("lost: {loss}{output}"));
        self.progress.say(&format!("{name} is started again; the run waits for it"));
        self.peers[seat] = None;
        self.feedings[seat] = None;
        let link = &self.link;
        match self.children.restart(seat, || link.forget_the_dead()) {
            Ok(true) => {}
            Ok(false) => {
                self.link.forget_the_dead();
                let seconds = self.setup.join_timeout_s;
                self.progress.say(&format!(
                    "{name} was started by hand: start it again, within {seconds} s"
                ));
            }
            // That it does not come back shows when its time is over.
            Err(e) => self.progress.say(&e.to_string()),
        }
        self.clock.stand_still();
        self.progress.waits();
        self.restarts.push(loss);
    }

    /// Prepares to give `seat` what it missed, if anything.
    pub(super) fn catch_up(&mut self, seat: usize) -> Result<Option<CatchUp>, LinkError> {
        let place = &self.lockstep.seats()[seat];
        let Some(ticks) = place.catch_up.map(|c| c.ticks).filter(|ticks| *ticks > 0) else {
            return Ok(None);
        };
        let service = format!("again-{seat}-{}", place.restarts);
        let source = match self.source.again() {
            Ok(source) => source,
            Err(e) => {
                self.end_for(e);
                return Ok(None);
            }
        };
        self.feedings[seat] = Some(Feeding {
            feed: self.link.feed(&service, seat)?,
            source,
            effects: Effects::of(self.source.header()),
            digest: RunDigest::default(),
            differs: false,
        });
        Ok(Some(CatchUp { ticks, service }))
    }

    /// Gives `seat` the next tick it missed.
    pub(super) fn feed(&mut self, seat: usize, tick: u64) -> Result<(), LinkError> {
        let Some(feeding) = &mut self.feedings[seat] else {
            // Whoever has catching up to do was given a feed when it joined.
            self.lockstep.abort();
            return Ok(());
        };
        let mut frame = feeding.feed.loan()?;
        let truth = match feeding.source.make(feeding.effects.command(), &mut frame) {
            Ok(truth) => truth,
            Err(e) => {
                self.end_for(e);
                return Ok(());
            }
        };
        frame.run_id = self.setup.run_id;
        frame.seal(&self.key, truth);
        feeding.digest.absorb_frame(&frame, truth);
        let (digest, has_scan) = (frame.digest(), frame.ranges_m().is_some());
        let now = feeding.feed.publish(frame)?;
        if tick < self.history.ticks() {
            let replies = self.history.replies(tick);
            feeding.close(self.setup.run_id, tick, &replies, self.lockstep.answering())?;
            feeding.effects.close(tick, has_scan, replies.into_iter());
        }
        self.lockstep.fed(seat, digest, now);
        self.link.stay_awake(now);
        let place = &self.lockstep.seats()[seat];
        self.link.wake_sleepers(std::iter::once((place.waiting_since_ns, place.awake_ns)));
        Ok(())
    }

    /// Compares what one who came back says with what it had said.
    pub(super) fn echo(&mut self, seat: usize, tick: u64, reply: Reply) {
        let place = &self.lockstep.seats()[seat];
        let Some(i) = self.lockstep.answering().iter().position(|&i| i == seat) else { return };
        let before = if tick < self.history.ticks() {
            self.history.replies(tick).get(i).copied()
        } else {
            place.reply
        };
        let differs = before.is_some_and(|before| !before.same_bits(&reply));
        if let Some(feeding) = self.feedings[seat].as_mut().filter(|f| differs && !f.differs) {
            feeding.differs = true;
            let remark = format!(
                "{} came back and answers tick {tick} otherwise than before: it depends on more \
                 than the run (a clock, a random number, a file), so this run cannot be repeated",
                place.name
            );
            self.progress.say(&remark);
            self.remarks.push(remark);
        }
    }
}

impl Feeding {
    /// The answers to a tick that all others have closed long ago. How long
    /// they took is not given again.
    fn close(
        &mut self,
        run_id: u64,
        tick: u64,
        replies: &[Reply],
        answering: &[usize],
    ) -> Result<(), LinkError> {
        self.digest.absorb_replies(replies.iter().copied());
        let digest = self.digest;
        self.feed.publish_tally(|tally| {
            tally.begin(run_id, tick);
            tally.run_digest = digest.run();
            tally.world_digest = digest.world();
            for (&seat, &reply) in answering.iter().zip(replies) {
                tally.push(if reply == Reply::Missing {
                    TallyEntry::missing(seat as u32)
                } else {
                    let mut answer = Answer::carrying(&Message::Reply(reply));
                    (answer.run_id, answer.tick) = (run_id, tick);
                    answer.participant = seat as u32;
                    TallyEntry::answered(answer, 0)
                });
            }
        })
    }
}
