//! Dead reckoning: wheels to pose, and nothing else.
//!
//! x̂ₜ = x̂ₜ₋₁ ⊞ (Δs, 0, Δθ) with Δs and Δθ from the encoder counts (Lynch and
//! Park, *Modern Robotics*, §13.4; the ⊞ of Solà et al., arXiv:1812.01537).
//! With the default options the arithmetic is the world's own, so every bit of drift
//! comes from the gap between wheel and floor. Reports no covariance: it has no belief
//! about it.
//!
//! [`Options`] adds the error of numerical integration: one step per N ticks, by a
//! [`Rule`]. Over a step Δs, Δθ of constant curvature with h = Δθ/2, the rules are off
//! by 0 ([`Rule::Exact`]), Δs·(1 − sin h/h) along the chord ([`Rule::Midpoint`]) and
//! Δs·√(1 − 2 sin h cos h/h + sin²h/h²) ([`Rule::Euler`]); all have the right heading.

use clap::{Args, ValueEnum};
use nalgebra::Vector3;
use rusty_contract::{Reply, Start};
use rusty_geometry::{DiffDrive, EncoderCounts, SE2, odometry_delta, trig};

use crate::{Filter, Tick};

/// Rule by which a step of the wheels becomes a step of the pose.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Rule {
    /// Along the arc
    #[default]
    Exact,
    /// Straight, in the heading halfway
    Midpoint,
    /// Straight, in the heading before
    Euler,
}

impl Rule {
    /// Returns `pose` moved by `delta` = (Δs m, 0, Δθ rad).
    #[must_use]
    pub fn step(self, pose: &SE2, delta: &Vector3<f64>) -> SE2 {
        let straight = |heading_rad: f64| {
            let (sin, cos) = trig::sin_cos(heading_rad);
            pose.compose(&SE2::new(delta.x * cos, delta.x * sin, delta.z))
        };
        match self {
            Self::Exact => pose.boxplus(delta),
            Self::Midpoint => straight(0.5 * delta.z),
            Self::Euler => straight(0.0),
        }
    }
}

/// Integrate the encoders
///
/// Dead reckoning (Modern Robotics, section 13.4). It begins at the initial pose if one
/// is given, otherwise at the origin. With --every N it integrates once in N ticks, over
/// the counts of all of them. Between two integrations the estimate is the last
/// integrated pose plus one step of the same rule over the counts since then: the
/// answers never lag, and their error is that of the longer step.
#[derive(Args, Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// Integrate the counts of N ticks in one step
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..=1 << 40))]
    pub every: u64,

    /// Rule of a step
    #[arg(long, value_enum, default_value_t)]
    pub rule: Rule,
}

impl Default for Options {
    /// The exact arc of every tick.
    fn default() -> Self {
        Self { every: 1, rule: Rule::Exact }
    }
}

/// The oldest navigation algorithm there is.
pub struct DeadReckoning {
    drive: DiffDrive,
    options: Options,
    /// The pose at the last integration, and the counts there.
    pose_in_world: SE2,
    last: EncoderCounts,
    /// Ticks since then.
    ticks: u64,
}

impl DeadReckoning {
    /// Starts at `pose_in_world` with counts of zero.
    #[must_use]
    pub fn new(drive: DiffDrive, pose_in_world: SE2) -> Self {
        let (options, last) = (Options::default(), EncoderCounts::default());
        Self { drive, options, pose_in_world, last, ticks: 0 }
    }

    /// Starts at the initial pose of a run, or at the origin.
    #[must_use]
    pub fn of_start(start: &Start) -> Self {
        Self::new(start.robot.drive, start.initial_pose.unwrap_or_default())
    }

    /// Integrates as these options say.
    #[must_use]
    pub fn with_options(self, options: Options) -> Self {
        Self { options, ..self }
    }

    /// Advances by one reading of the encoders and says where that leads.
    pub fn advance(&mut self, ticks: EncoderCounts) -> SE2 {
        let delta = odometry_delta(self.last, ticks, &self.drive);
        let pose_in_world = self.options.rule.step(&self.pose_in_world, &delta);
        self.ticks += 1;
        if self.ticks >= self.options.every {
            (self.pose_in_world, self.last, self.ticks) = (pose_in_world, ticks, 0);
        }
        pose_in_world
    }
}

impl Filter for DeadReckoning {
    fn update(&mut self, tick: &Tick<'_>) -> Reply {
        self.advance(tick.encoders()).into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Counts of left and right wheel in a tick of the circle of the tests.
    const CIRCLE: [i64; 2] = [190, 210];

    /// The estimates of `ticks` ticks on the circle, from the origin.
    fn estimates(options: Options, ticks: i64) -> Vec<SE2> {
        let reckoning = DeadReckoning::new(DiffDrive::rusty(), SE2::identity());
        let mut reckoning = reckoning.with_options(options);
        let [left, right] = CIRCLE;
        let counts = |k: i64| EncoderCounts { left: left * k, right: right * k };
        (1..=ticks).map(|k| reckoning.advance(counts(k))).collect()
    }

    /// The same with the closed form: chords of `chord_m` whose first points
    /// `first_rad` off the robot's axis, each turned by `turn_rad` from the last:
    /// c·sin(nh)/sin(h) in the direction first + (n − 1)h, h = turn/2.
    fn polygon(chord_m: f64, first_rad: f64, turn_rad: f64, n: f64) -> SE2 {
        let half_rad = 0.5 * turn_rad;
        let reach_m = chord_m * trig::sin(n * half_rad) / trig::sin(half_rad);
        let (sin, cos) = trig::sin_cos(first_rad + (n - 1.0) * half_rad);
        SE2::new(reach_m * cos, reach_m * sin, n * turn_rad)
    }

    fn gap_m(a: &SE2, b: &SE2) -> f64 {
        (a.translation() - b.translation()).norm()
    }

    /// (Δs m, 0, Δθ rad) of N ticks.
    fn delta(every: u64) -> Vector3<f64> {
        let counts = CIRCLE.map(|count| count * every as i64);
        let counts = EncoderCounts { left: counts[0], right: counts[1] };
        odometry_delta(EncoderCounts::default(), counts, &DiffDrive::rusty())
    }

    #[test]
    fn a_step_of_each_rule_is_off_by_its_closed_form() {
        for every in [1, 10, 50] {
            let (delta, exact) = (delta(every), SE2::exp(&delta(every)));
            let h = 0.5 * delta.z;
            let (sinc, cos) = (trig::sinc(h), trig::cos(h));
            let step = |rule: Rule| rule.step(&SE2::identity(), &delta);
            assert_eq!(step(Rule::Exact), exact);
            let midpoint = step(Rule::Midpoint);
            assert!((gap_m(&midpoint, &exact) - delta.x * (1.0 - sinc)).abs() < 1e-14);
            // Purely radial: along the chord.
            let across = midpoint.x() * exact.y() - midpoint.y() * exact.x();
            assert!(across.abs() < 1e-14, "{across}");
            let euler_m = delta.x * (1.0 - 2.0 * sinc * cos + sinc * sinc).sqrt();
            assert!((gap_m(&step(Rule::Euler), &exact) - euler_m).abs() < 1e-12);
            assert_eq!(midpoint.theta(), exact.theta());
            assert_eq!(step(Rule::Euler).theta(), exact.theta());
        }
    }

    #[test]
    fn on_a_circle_the_error_of_many_steps_is_that_of_a_polygon() {
        for every in [1, 10, 25] {
            let (delta, n) = (delta(every), 400 / every);
            let at_end = |rule| *estimates(Options { every, rule }, 400).last().unwrap();
            let (turn, half) = (delta.z, 0.5 * delta.z);
            let chords = [
                (Rule::Exact, delta.x * trig::sinc(half), half),
                (Rule::Midpoint, delta.x, half),
                (Rule::Euler, delta.x, 0.0),
            ];
            for (rule, chord_m, first_rad) in chords {
                let expected = polygon(chord_m, first_rad, turn, n as f64);
                let off_m = gap_m(&at_end(rule), &expected);
                assert!(off_m < 1e-11, "{rule:?}, every {every}: {off_m}");
            }
        }
    }

    #[test]
    fn between_integrations_the_estimate_is_one_longer_step() {
        let (every, ticks) = (10, 25);
        for rule in [Rule::Exact, Rule::Midpoint, Rule::Euler] {
            let found = estimates(Options { every, rule }, ticks);
            let mut integrated = SE2::identity();
            for (k, found) in (1..).zip(&found) {
                let since = (k - 1) % every + 1;
                let expected = rule.step(&integrated, &delta(since));
                assert_eq!(*found, expected, "{rule:?}, tick {k}");
                if since == every {
                    integrated = expected;
                }
            }
        }
    }

    #[test]
    fn by_default_every_tick_is_an_arc_bit_for_bit() {
        let mut pose = SE2::identity();
        for found in estimates(Options::default(), 100) {
            pose = pose.boxplus(&delta(1));
            assert_eq!(found, pose);
        }
    }
}
