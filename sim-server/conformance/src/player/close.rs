//! The end of a tick: the answers of all go to scorers and loggers.

use rusty_contract::answer::Message;
use rusty_contract::tally::TallyEntry;
use rusty_contract::{Answer, Reply};
use rusty_geometry::odometry_delta;

use super::Player;
use crate::fault::Halt;
use crate::transcript::Response;

impl Player<'_> {
    /// Closes the tick: scorers and loggers get its answers.
    pub(crate) fn close(&mut self) -> Result<(), Halt> {
        let delta = odometry_delta(
            self.companion.1,
            self.frame.encoders(),
            &self.header.config.robot.nominal().drive,
        );
        self.companion = (self.companion.0.boxplus(&delta), self.frame.encoders());
        let reply = Reply::from(self.companion.0);
        let client = self
            .kit
            .role
            .answers()
            .then(|| self.said.answers.last().and_then(Response::reply).unwrap_or_default());
        let replies: Vec<Reply> = std::iter::once(reply).chain(client).collect();
        self.digest.absorb_replies(replies.into_iter());
        if self.kit.role.holds_key() {
            let mut answer = Answer::carrying(&Message::Reply(reply));
            answer.run_id = self.identity.run_id;
            answer.tick = self.frame.tick();
            answer.digest_seen = self.frame.digest();
            let digest = self.digest;
            self.link.publish_tally(|tally| {
                tally.begin(answer.run_id, answer.tick);
                tally.run_digest = digest.run();
                tally.world_digest = digest.world();
                tally.push(TallyEntry::answered(answer, 0));
            })?;
        }
        self.closed += 1;
        Ok(())
    }
}
