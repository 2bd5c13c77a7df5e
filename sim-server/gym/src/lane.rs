//! A lane: one world of many, and what was seen of it last.

use rusty_contract::{Frame, RunConfig, RunDigest, ScriptConfig};
use rusty_geometry::{EncoderCounts, Twist};
use rusty_sim::{Sim, SimError, StepOutcome};

use crate::layout::Layout;

/// One world. Its frames have the bits of a run with the same seed and commands.
#[derive(Clone)]
pub struct Lane {
    sim: Sim,
    seen: Seen,
    row: Vec<f32>,
}

/// What was seen since the start.
#[derive(Clone, Copy, Default)]
struct Seen {
    digest: RunDigest,
    frame_digest: u64,
    counts: EncoderCounts,
    is_blocked: bool,
}

impl Lane {
    /// The world of `config` before its first tick, driven by the commands of
    /// [`Lane::step`] in place of its script.
    ///
    /// # Errors
    /// [`SimError`] when the configuration cannot be used.
    pub fn new(config: RunConfig, layout: &Layout) -> Result<Self, SimError> {
        let sim = Sim::new(RunConfig { script: ScriptConfig::Driver {}, ..config })?;
        Ok(Self { sim, seen: Seen::default(), row: layout.first_row() })
    }

    /// Back before the first tick, with another seed.
    ///
    /// # Errors
    /// [`SimError`] when a crowd finds no room with this seed; nothing changes then.
    pub fn restart(&mut self, seed: u64, layout: &Layout) -> Result<(), SimError> {
        if self.sim.config().crowd.is_some() {
            // `Sim::restart` keeps a crowd that finds no room where it was.
            self.sim = Sim::new(RunConfig { seed, ..self.sim.config().clone() })?;
        } else {
            self.sim.restart(seed);
        }
        self.seen = Seen::default();
        self.row = layout.first_row();
        Ok(())
    }

    /// Makes a tick with this command, which must be finite. `frame` is overwritten.
    pub fn step(&mut self, command: Twist, layout: &Layout, frame: &mut Frame) {
        let outcome = self.sim.step(Some(command), frame);
        frame.write_digest(true);
        layout.write(frame, self.seen.counts, &mut self.row);
        self.seen.digest.absorb_frame(frame, Some(self.sim.truth()));
        // No participant answers.
        self.seen.digest.absorb_replies([].into_iter());
        self.seen.frame_digest = frame.digest();
        self.seen.counts = frame.encoders();
        self.seen.is_blocked = outcome == StepOutcome::Blocked;
    }

    /// The configuration, with the seed of the last restart.
    pub fn config(&self) -> &RunConfig {
        self.sim.config()
    }

    /// The number of ticks since the start.
    pub fn tick_count(&self) -> u64 {
        self.sim.tick()
    }

    /// The true pose: x m, y m, θ rad, world frame.
    pub fn truth(&self) -> [f64; 3] {
        let pose = self.sim.truth();
        [pose.x(), pose.y(), pose.theta()]
    }

    /// Whether a wall, a person or another robot stopped the robot in the last tick.
    pub fn is_blocked(&self) -> bool {
        self.seen.is_blocked
    }

    /// The digest of the last frame; 0 before the first tick.
    pub fn frame_digest(&self) -> u64 {
        self.seen.frame_digest
    }

    /// The digests of all frames since the start.
    pub fn digest(&self) -> &RunDigest {
        &self.seen.digest
    }

    /// The observation, in the order of the layout.
    pub fn row(&self) -> &[f32] {
        &self.row
    }
}
