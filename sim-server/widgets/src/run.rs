//! One run: the world, its estimators and its digests, tick by tick, as `launch` has it.
//!
//! A row has f64 words: tick, time, true x, y, θ, command v, ω, distance driven, 1 if a
//! wall held the robot; then for each estimator its x, y, θ, the ellipse that holds 95 %
//! (x by x, y by x, y by y of what a unit circle becomes), position error, heading error
//! and NEES. Metres, radians, seconds, world frame; a number that is not known is NaN.

use rusty_contract::config::Kidnapping;
use rusty_contract::log::Source;
use rusty_contract::{Frame, LogHeader, OnLoss, Reply, RunDigest, ScriptConfig};
use rusty_geometry::{SE2, Twist};
use rusty_metrics::{PathLength, nees};
use rusty_plot::ellipse::of_pose;
use rusty_sim::{BuiltInScript, Sim, StepOutcome};

use crate::config::read;
use crate::roster::{Entry, entries};

/// A run on its way.
pub struct Run {
    /// Configuration, whose script is a driver, and roster.
    pub header: LogHeader,
    sim: Sim,
    /// The frame of the latest tick.
    pub frame: Box<Frame>,
    script: BuiltInScript,
    driven: Option<Twist>,
    /// Commands of a run before, in the place of the script.
    kept: Vec<Twist>,
    /// The command of each tick, before the wheels limited it.
    pub commands: Vec<Twist>,
    /// The digests up to now.
    pub digest: RunDigest,
    path: PathLength,
    /// Length of the path up to the latest kidnapping by [`Run::kidnap`], m.
    before_m: f64,
    /// Ticks in which a wall held the robot.
    pub blocked_ticks: u64,
    /// The latest scan, m; empty before the first.
    pub ranges_m: Vec<f64>,
    /// The estimators, in roster order.
    pub entries: Vec<Entry>,
    /// Answers to the latest tick; reused.
    replies: Vec<Reply>,
}

impl Run {
    /// Begins a run of the scenario in `text`, see [`config`](crate::config), with
    /// `commands` in the place of its script if there are any.
    ///
    /// # Errors
    /// A sentence that names what cannot be used.
    pub fn open(text: &str, seed: u64, kept: Vec<Twist>) -> Result<Self, String> {
        let (mut config, roster) = read(text, seed)?;
        if !kept.is_empty() {
            config.script = ScriptConfig::Commands { file: None, list: kept.clone() };
        }
        config.script.check().map_err(|e| e.to_string())?;
        let script = BuiltInScript::new(&config.script, config.dt_s, config.start);
        // Every command comes from here, so that one can be replaced at any tick.
        config.script = ScriptConfig::Driver {};
        let sim = Sim::new(config.clone()).map_err(|e| e.to_string())?;
        let header = LogHeader {
            writer: String::new(),
            source: Source::Simulated,
            config,
            roster,
            on_loss: OnLoss::default(),
        };
        let mut run = Self {
            entries: Vec::new(),
            replies: Vec::new(),
            path: PathLength::default(),
            before_m: 0.0,
            digest: RunDigest::default(),
            frame: Frame::boxed(),
            driven: None,
            kept,
            commands: Vec::new(),
            blocked_ticks: 0,
            ranges_m: Vec::new(),
            header,
            sim,
            script,
        };
        run.restart(seed)?;
        Ok(run)
    }

    /// Goes back before the first tick, with another seed.
    ///
    /// # Errors
    /// A sentence that names the estimator that cannot begin.
    pub fn restart(&mut self, seed: u64) -> Result<(), String> {
        self.header.config.seed = seed;
        self.sim.restart(seed);
        let config = &self.header.config;
        let carried_at = config.kidnappings.iter().map(|k| k.tick).collect();
        self.path = PathLength::new(Some(config.start), carried_at);
        self.before_m = 0.0;
        self.digest = RunDigest::default();
        self.entries = entries(&self.header)?;
        self.commands.clear();
        self.ranges_m.clear();
        self.blocked_ticks = 0;
        Ok(())
    }

    /// Simulates a tick, and adds its row.
    pub fn step(&mut self, row: &mut Vec<f64>) {
        let (tick, before) = (self.sim.tick(), self.sim.truth());
        let scripted = self.script.command_at(tick, &before, None);
        let command = self.driven.unwrap_or(scripted);
        self.commands.push(command);
        let outcome = self.sim.step(Some(command), &mut self.frame);
        let is_blocked = outcome == StepOutcome::Blocked;
        self.blocked_ticks += u64::from(is_blocked);
        let truth = self.sim.truth();
        self.path.push(tick, &truth);
        self.frame.write_digest(true);
        self.digest.absorb_frame(&self.frame, Some(truth));
        if let Some(ranges_m) = self.frame.ranges_m() {
            self.ranges_m.clear();
            self.ranges_m.extend_from_slice(ranges_m);
        }
        let Twist { v_m_s, omega_rad_s } = self.frame.command();
        row.extend([tick as f64, self.frame.time_s(), truth.x(), truth.y(), truth.theta()]);
        row.extend([v_m_s, omega_rad_s, self.distance_m(), f64::from(u8::from(is_blocked))]);
        self.replies.clear();
        for Entry { estimator, errors, .. } in &mut self.entries {
            let reply = estimator.update(&self.frame);
            let reply = if reply.check().is_ok() { reply } else { Reply::Abstain };
            match reply.estimate() {
                Some(estimate) => {
                    let at = estimate.pose_in_world;
                    let [position_m, heading_rad] = errors.push(&at, &truth);
                    let nees = estimate.covariance.and_then(|p| nees(&truth, &at, &p));
                    row.extend([at.x(), at.y(), at.theta()]);
                    let ellipse = estimate.covariance.and_then(|p| of_pose(at.theta(), &p));
                    row.extend(ellipse.unwrap_or([f64::NAN; 3]));
                    row.extend([position_m, heading_rad, nees.unwrap_or(f64::NAN)]);
                }
                None => row.extend([f64::NAN; 9]),
            }
            self.replies.push(reply);
        }
        self.digest.absorb_replies(self.replies.iter().copied());
    }

    /// Replaces the script from the next tick on.
    ///
    /// # Errors
    /// The command is not finite, or beyond what a command can be.
    pub fn drive(&mut self, command: Twist) -> Result<(), String> {
        let tick = self.sim.tick();
        ScriptConfig::check_command(tick, command).map_err(|e| e.to_string())?;
        self.driven = Some(command);
        Ok(())
    }

    /// Puts the robot elsewhere at the start of the next tick, whose index is returned.
    /// Later kidnappings of the scenario do not happen.
    ///
    /// # Errors
    /// A wall is there.
    pub fn kidnap(&mut self, to: SE2) -> Result<u64, String> {
        let (mut config, tick) = (self.sim.config().clone(), self.sim.tick());
        config.kidnappings.retain(|k| k.tick < tick);
        config.kidnappings.push(Kidnapping { tick, to });
        self.sim.reconfigure(config).map_err(|e| e.to_string())?;
        self.header.config = self.sim.config().clone();
        self.before_m = self.distance_m();
        self.path = PathLength::new(Some(to), Vec::new());
        Ok(tick)
    }

    /// Number of ticks up to now.
    #[must_use]
    pub fn tick_count(&self) -> u64 {
        self.sim.tick()
    }

    /// Distance truly driven, m.
    #[must_use]
    pub fn distance_m(&self) -> f64 {
        self.before_m + self.path.metres()
    }

    /// The same, and those that are left of a run before.
    #[must_use]
    pub fn commands_to_keep(&self) -> Vec<Twist> {
        let rest = self.kept.get(self.commands.len()..).filter(|_| self.driven.is_none());
        [&self.commands, rest.unwrap_or_default()].concat()
    }

    /// Adds the belief of an estimator: x, y, θ and weight of each pose.
    pub fn belief(&self, index: usize, numbers: &mut Vec<f64>) {
        let mut poses = Vec::new();
        self.entries.iter().skip(index).take(1).for_each(|e| e.estimator.belief(&mut poses));
        numbers.extend(poses.iter().flat_map(|p| [p.x_m, p.y_m, p.theta_rad, p.weight]));
    }
}
