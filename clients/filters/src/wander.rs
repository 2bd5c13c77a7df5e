//! A driver without a map or an aim: straight on while there is room, then some
//! other free direction.
//!
//! It reacts to what the laser shows and to nothing else: [`crate::steering`]
//! finds a free direction near the one it wishes for, and [`crate::surroundings`]
//! keeps every command admissible. The wish is a heading in the frame of the
//! odometry, drawn anew where the way ends and every few seconds: each direction
//! with a chance in proportion to the square of how far it is free, so that a
//! door is found from the middle of a room.

use clap::Args;
use rusty_clients::{ClientError, Filter, Tick};
use rusty_contract::{Reply, Start, errln};
use rusty_geometry::{EncoderTicks, Twist, wrap_angle};

use crate::localiser::{Localiser, Reckoning};
use crate::steering::{free_direction, sectors, steer};
use crate::surroundings::{Caution, Surroundings};
use crate::{OdometryNoise, Random};

/// A way shorter than this is at its end, m.
const END_M: f64 = 0.35;

/// A wish is kept for 5 to 15 s.
const KEPT_S: [f64; 2] = [5.0, 15.0];

/// What a wanderer believes and wants.
#[derive(Args, Clone, Copy, Debug, Default, PartialEq)]
pub struct Options {
    /// Seed of where it wishes to go
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,

    /// How careful it is.
    #[command(flatten)]
    pub caution: Caution,

    /// What is believed of the wheels.
    #[command(flatten)]
    pub odometry: OdometryNoise,
}

/// Drives about.
#[derive(Debug)]
pub struct Wander {
    name: String,
    around: Surroundings,
    reckoning: Reckoning,
    /// Whether the pose means something to others.
    placed: bool,
    caution: Caution,
    random: Random,
    dt_s: f64,
    /// Heading in the odometry frame, and for how many ticks more.
    wish_rad: f64,
    keep_ticks: u64,
    /// The direction that was free at the last scan, odometry frame.
    course_rad: f64,
}

impl Wander {
    /// Begins without a wish: the first scan makes one.
    #[must_use]
    pub fn new(start: &Start, options: &Options) -> Self {
        Self {
            name: start.name.clone(),
            around: Surroundings::new(start, &options.caution),
            reckoning: Reckoning::new(start, options.odometry),
            placed: start.initial_pose.is_some(),
            caution: options.caution,
            random: Random::new(options.seed, 1),
            dt_s: start.dt_s,
            wish_rad: 0.0,
            keep_ticks: 0,
            course_rad: 0.0,
        }
    }

    /// The command for the next tick, from the counts and the scan at the end of
    /// this one.
    pub fn command(&mut self, ticks: EncoderTicks, ranges_m: Option<&[f64]>) -> Twist {
        self.around.tick(ticks, ranges_m);
        let heading_rad = self.around.pose_in_odometry().theta();
        self.keep_ticks = self.keep_ticks.saturating_sub(1);
        if ranges_m.is_some() {
            let wished_rad = wrap_angle(self.wish_rad - heading_rad);
            if self.keep_ticks == 0 || self.around.clear_towards_m(wished_rad, 0.0) < END_M {
                self.wish(heading_rad);
            }
            let wished_rad = wrap_angle(self.wish_rad - heading_rad);
            let (free_rad, _) = free_direction(&self.around, wished_rad, END_M);
            self.course_rad = heading_rad + free_rad;
        }
        let bearing_rad = wrap_angle(self.course_rad - heading_rad);
        steer(&self.around, bearing_rad, &self.caution)
    }

    /// Draws a wish: a sector by the square of how far it is free.
    fn wish(&mut self, heading_rad: f64) {
        let weights = || sectors(&self.around).map(|(rad, far_m)| (rad, far_m * far_m));
        let all: f64 = weights().map(|(_, weight)| weight).sum();
        let mut left = all * self.random.uniform();
        let share = self.random.uniform();
        let chosen = weights().find(|(_, weight)| {
            left -= weight;
            left < 0.0
        });
        // Where nothing is free anywhere, it turns round.
        let bearing_rad = chosen.map_or(std::f64::consts::PI, |(rad, _)| rad);
        self.wish_rad = wrap_angle(heading_rad + bearing_rad);
        let kept_s = KEPT_S[0] + (KEPT_S[1] - KEPT_S[0]) * share;
        self.keep_ticks = (kept_s / self.dt_s).ceil() as u64;
    }
}

impl Filter for Wander {
    const SHOWS_BELIEF: bool = false;

    fn tick(&mut self, tick: &Tick<'_>) -> Reply {
        self.reckoning.advance(tick.ticks());
        let command = self.command(tick.ticks(), tick.ranges_m());
        if self.placed {
            Reply::Both(self.reckoning.estimate(None), command)
        } else {
            Reply::Command(command)
        }
    }

    /// Says why, if it stood all the time.
    fn finish(self) -> Result<(), ClientError> {
        if !self.around.remark().is_empty() {
            errln!("{}: stood{}", self.name, self.around.remark());
        }
        Ok(())
    }
}
