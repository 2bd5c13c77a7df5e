//! `Transcript`: what a client said in a little run.

use rusty_contract::answer::Message;
use rusty_contract::{Answer, AnswerError, Reply};

use super::fault::Fault;

/// One thing the client said, and what was asked at that moment.
#[derive(Clone, Debug)]
pub(super) struct Response {
    /// What travelled.
    pub(super) answer: Answer,
    /// What it means.
    pub(super) message: Result<Message, AnswerError>,
    /// The tick that was asked, and the digest of its frame.
    pub(super) asked: (u64, u64),
}

/// All that a client said to ticks, and how its run came to grief, if it did.
#[derive(Clone, Debug, Default)]
pub(super) struct Transcript {
    /// The first answer to every tick, in order.
    pub(super) answers: Vec<Response>,
    /// All other answers: second ones, to older ticks, of other runs.
    pub(super) strays: Vec<Response>,
    /// Why the run did not come to its end.
    pub(super) fault: Option<Fault>,
}

impl Response {
    /// The reply, if it is one that can be used.
    pub(super) fn reply(&self) -> Option<Reply> {
        match self.message {
            Ok(Message::Reply(reply)) => Some(reply),
            _ => None,
        }
    }

    fn same_bits(&self, other: &Self) -> bool {
        match (self.reply(), other.reply()) {
            (Some(a), Some(b)) => a.same_bits(&b),
            // NaN is equal to no NaN; as text it is.
            _ => format!("{:?}", self.message) == format!("{:?}", other.message),
        }
    }

    fn text(&self) -> String {
        match &self.message {
            Ok(Message::Reply(reply)) => reply_text(reply),
            Ok(other) => format!("{other:?}"),
            Err(e) => e.to_string(),
        }
    }
}

fn reply_text(reply: &Reply) -> String {
    let mut text = String::new();
    if let Some(e) = reply.estimate() {
        let p = e.pose_in_world;
        text = format!("pose ({}, {}, {})", p.x(), p.y(), p.theta());
        if e.covariance.is_some() {
            text.push_str(" with covariance");
        }
        if let Some(innovation) = e.innovation {
            text.push_str(&format!(" with innovation {}", innovation.nis));
        }
    }
    if let Some(c) = reply.command() {
        let and = if text.is_empty() { "" } else { " and " };
        text = format!("{text}{and}command ({}, {})", c.v_m_s, c.omega_rad_s);
    }
    if text.is_empty() { format!("{reply:?}").to_lowercase() } else { text }
}

impl Transcript {
    /// The first tick at which this differs from the answers of another run, as
    /// the end of a sentence; `None` where all bits are equal as far as both go.
    pub(super) fn difference(&self, undisturbed: &Self) -> Option<String> {
        let pairs = self.answers.iter().zip(&undisturbed.answers);
        let (here, there) = pairs.into_iter().find(|(a, b)| !a.same_bits(b))?;
        Some(format!(
            "tick {}: {}, in the undisturbed run {}",
            here.asked.0,
            here.text(),
            there.text()
        ))
    }
}
