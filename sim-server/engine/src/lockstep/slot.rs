//! One participant's place in the protocol, and how it can be lost.

use rusty_contract::{Answer, Participant, Reply, Role};
use serde::Serialize;

/// One participant's place.
#[derive(Clone, Debug)]
pub struct Slot {
    /// Name in the roster.
    pub name: String,
    /// Role in the roster.
    pub(crate) role: Role,
    /// Whether ticks wait for it.
    pub(crate) awaited: bool,
    /// Where it stands.
    pub state: ParticipantState,
    /// Its process, once it has joined.
    pub(crate) pid: u32,
    /// How long it stays awake while waiting, ns.
    pub(crate) awake_ns: u64,
    /// When it began to wait for the next frame, ns.
    pub(crate) waiting_since_ns: u64,
    /// Its reply to the current tick.
    pub(crate) reply: Option<Reply>,
    /// The answer that carried it.
    pub(crate) last: Answer,
    /// What the current answer took, ns, as the server saw it.
    pub(crate) latency_ns: u64,
    /// Answers that were not asked for, or asked for before.
    pub(crate) strays: u64,
    /// How often it was slow.
    pub(crate) slow: u64,
    /// What it was given when it joined; answers must carry it.
    pub(crate) ticket: u32,
    /// What it is being given again, after it came back.
    pub(crate) catch_up: Option<CatchingUp>,
    /// How often it came back.
    pub(crate) restarts: u64,
    /// How often in a row it was lost again before it had answered anything new.
    pub(super) fruitless: u32,
    pub(super) slow_said: bool,
    answers: u64,
    abstained: u64,
    latency_sum_ns: u64,
    latency_max_ns: u64,
    compute_sum_ns: u64,
}

/// Where a participant stands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ParticipantState {
    /// It has not asked to join.
    Absent,
    /// It was told to come in.
    Joined,
    /// Its ports are open.
    Ready,
    /// It was lost, and is expected back. `called`: its program has been
    /// started again, since when is known.
    Away {
        /// Since when it is expected back, ns.
        since_ns: u64,
        /// Whether its program is being started again.
        called: bool,
    },
    /// It left when it should.
    Left,
    /// It is lost.
    Lost(Loss),
}

/// Where a participant that came back stands among the ticks it missed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct CatchingUp {
    /// How many ticks it is given again.
    pub(crate) ticks: u64,
    /// The one it is at.
    pub(crate) next: u64,
    /// Digest of that frame and when it was sent, ns; none before.
    pub(crate) sent: Option<(u64, u64)>,
    /// Since when it is expected back, ns.
    pub(crate) since_ns: u64,
}

/// A participant that is lost.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Loss {
    /// Its slot.
    #[serde(skip)]
    pub slot: usize,
    /// Its name.
    pub name: String,
    /// In which way.
    pub kind: LossKind,
    /// At which tick; none before the first.
    pub tick: Option<u64>,
    /// What is known.
    pub detail: String,
}

/// The ways of being lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum LossKind {
    /// It never joined, or never opened its ports.
    NeverAttached,
    /// It lives but did not answer in time.
    Stalled,
    /// Its process ended.
    Dead,
    /// It said itself that it failed.
    Failed,
    /// It left before the end.
    Left,
    /// It sent something that is no answer.
    Invalid,
}

impl LossKind {
    /// Whether starting the program again may help. One that sends what is no
    /// answer would send it again; one that never came has not begun.
    pub(super) fn may_come_back(self) -> bool {
        matches!(self, Self::Stalled | Self::Dead | Self::Failed | Self::Left)
    }

    /// The word for it.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::NeverAttached => "never attached",
            Self::Stalled => "stalled",
            Self::Dead => "dead",
            Self::Failed => "failed",
            Self::Left => "left",
            Self::Invalid => "sent an invalid answer",
        }
    }
}

impl std::fmt::Display for Loss {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} {}", self.name, self.kind.word())?;
        if let Some(tick) = self.tick {
            write!(f, " at tick {tick}")?;
        }
        write!(f, ": {}", self.detail)
    }
}

/// What a participant did in a run, for tables and JSON.
#[derive(Clone, Debug, Serialize)]
pub struct ParticipantSummary {
    /// Name in the roster.
    pub name: String,
    /// Role in the roster.
    pub role: Role,
    /// Its process; null if it never joined.
    pub pid: Option<u32>,
    /// Answers to ticks, abstentions among them.
    pub answers: u64,
    /// Ticks on which it abstained.
    pub abstained: u64,
    /// Answers that were not asked for, or asked for before.
    pub strays: u64,
    /// How often the server had to say that it is slow.
    pub slow: u64,
    /// How often it was lost and came back.
    pub restarts: u64,
    /// Mean time from frame to answer as it reported, µs.
    pub compute_mean_us: f64,
    /// Mean time from publication to answer as the server saw it, µs.
    pub latency_mean_us: f64,
    /// The longest of those, µs.
    pub latency_max_us: f64,
    /// How it was lost; null if it was not.
    pub lost: Option<Loss>,
}

impl Slot {
    pub(super) fn new(participant: &Participant) -> Self {
        Self {
            name: participant.name.clone(),
            role: participant.role,
            awaited: participant.is_awaited(),
            state: ParticipantState::Absent,
            pid: 0,
            awake_ns: 0,
            waiting_since_ns: 0,
            reply: None,
            last: Answer::default(),
            latency_ns: 0,
            ticket: 0,
            catch_up: None,
            restarts: 0,
            fruitless: 0,
            strays: 0,
            slow: 0,
            slow_said: false,
            answers: 0,
            abstained: 0,
            latency_sum_ns: 0,
            latency_max_ns: 0,
            compute_sum_ns: 0,
        }
    }

    pub(super) fn leave(&mut self) {
        if !matches!(self.state, ParticipantState::Lost(_)) {
            self.state = ParticipantState::Left;
        }
    }

    pub(super) fn accept(&mut self, answer: Answer, reply: Reply, latency_ns: u64) {
        self.answers += 1;
        self.abstained += u64::from(reply == Reply::Abstain);
        self.latency_ns = latency_ns;
        self.latency_sum_ns = self.latency_sum_ns.saturating_add(latency_ns);
        self.latency_max_ns = self.latency_max_ns.max(latency_ns);
        self.compute_sum_ns = self.compute_sum_ns.saturating_add(answer.compute_ns);
        self.last = answer;
        self.reply = Some(reply);
        self.fruitless = 0;
    }

    /// Whether it takes part and has nothing to catch up on.
    pub(super) fn is_up_to_date(&self) -> bool {
        self.state == ParticipantState::Ready && self.catch_up.is_none()
    }

    /// Whether it was lost and is not yet where the others are.
    pub(super) fn is_coming_back(&self) -> bool {
        match self.state {
            ParticipantState::Away { .. } => true,
            ParticipantState::Joined | ParticipantState::Ready => self.catch_up.is_some(),
            _ => false,
        }
    }

    /// Whether a process is expected to be there.
    pub(crate) fn is_present(&self) -> bool {
        matches!(self.state, ParticipantState::Joined | ParticipantState::Ready)
    }

    /// How it was lost, if it was.
    #[must_use]
    pub fn loss(&self) -> Option<&Loss> {
        match &self.state {
            ParticipantState::Lost(loss) => Some(loss),
            _ => None,
        }
    }

    /// What it did.
    #[must_use]
    pub fn summary(&self) -> ParticipantSummary {
        let mean_us = |sum_ns: u64| {
            if self.answers == 0 { 0.0 } else { sum_ns as f64 * 1e-3 / self.answers as f64 }
        };
        ParticipantSummary {
            name: self.name.clone(),
            role: self.role,
            pid: (self.pid != 0).then_some(self.pid),
            answers: self.answers,
            abstained: self.abstained,
            strays: self.strays,
            slow: self.slow,
            restarts: self.restarts,
            compute_mean_us: mean_us(self.compute_sum_ns),
            latency_mean_us: mean_us(self.latency_sum_ns),
            latency_max_us: self.latency_max_ns as f64 * 1e-3,
            lost: self.loss().cloned(),
        }
    }
}
