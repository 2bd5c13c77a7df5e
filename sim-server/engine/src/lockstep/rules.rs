//! What the machine is told of a run, and what it says to do.

use rusty_contract::{OnLoss, Phase, Reply};

use super::Loss;

/// What the machine must know of a run.
#[derive(Clone, Debug)]
pub struct Rules {
    /// This run; answers that carry another id belong to another.
    pub run_id: u64,
    /// How many ticks.
    pub ticks: u64,
    /// What happens when an awaited participant is lost.
    pub on_loss: OnLoss,
    /// How long all may take to join, ns.
    pub join_timeout_ns: u64,
    /// How long an answer may take, ns.
    pub answer_timeout_ns: u64,
    /// How long a participant may take to leave, ns: a scorer draws.
    pub leave_timeout_ns: u64,
    /// The same where the run ends before its last tick, ns.
    pub early_leave_timeout_ns: u64,
    /// From when on a missing answer is worth a notice, ns.
    pub slow_after_ns: u64,
}

/// What to do next.
#[derive(Clone, Debug, PartialEq)]
pub enum Step {
    /// Nothing before the next event or this time.
    Wait {
        /// Ask again at the latest then, ns.
        until_ns: u64,
    },
    /// Make the frame of this tick and publish it; then call
    /// [`Lockstep::published`](super::Lockstep::published).
    Publish(u64),
    /// All answers to this tick are in: absorb them.
    Close(u64),
    /// A participant is slow. Report it, and go on waiting.
    Slow {
        /// The slot.
        slot: usize,
        /// How long it has taken so far, ns.
        waited_ns: u64,
    },
    /// A participant is lost. Report it.
    Lost(Loss),
    /// A participant is lost and shall come back. Start its program again.
    Restart(Loss),
    /// Send this tick again, to one that came back and to no other; then
    /// call `Lockstep::fed`.
    Feed {
        /// The slot.
        slot: usize,
        /// The tick.
        tick: u64,
    },
    /// One who came back has answered a tick that had its answer already. If
    /// it is another one, say so.
    Echo {
        /// The slot.
        slot: usize,
        /// The tick.
        tick: u64,
        /// What it says now.
        reply: Reply,
    },
    /// Publish the end of the run.
    End(Phase),
    /// The run is over.
    Finished,
}
