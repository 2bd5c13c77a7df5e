//! A driver without a map or an aim: straight on while there is room, then some
//! other free direction.
//!
//! It reacts to what the laser shows and to nothing else: [`crate::steering`]
//! finds a free direction near the one it wants, and [`crate::surroundings`]
//! keeps every command admissible. The wish is a heading in the frame of the
//! odometry, drawn anew where the way ends and every few seconds: each direction
//! with a chance in proportion to the square of how far it is free, so that a
//! door is found from the middle of a room.

use clap::Args;
use rusty_clients::ClientError;
use rusty_contract::{Start, errln};
use rusty_geometry::{Twist, wrap_angle};

use crate::driver::{Driver, Known, Task};
use crate::pilot::Pilot;
use crate::reckoning::Reckoning;
use crate::steering::{free_direction, sectors, steer};
use crate::surroundings::{Caution, Surroundings};
use crate::{OdometryNoise, Random};

/// A way shorter than this is at its end, m.
const END_M: f64 = 0.35;

/// A wish is kept for 5 to 15 s.
const KEPT_S: [f64; 2] = [5.0, 15.0];

/// Drive through free space without a map
///
/// The driver goes straight while the way is free, then turns to another free
/// direction. It sends no command that could touch, before the next scan, a wall that
/// its laser has hit. It does not see walls between the beams, and it assumes that
/// commands take effect within the time of one scan. The scenario needs a script of
/// kind "driver"; the role is driver. If it gets the initial pose, it also answers
/// with dead reckoning.
#[derive(Args, Clone, Copy, Debug, Default, PartialEq)]
pub struct Options {
    /// Seed of the random headings
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
    caution: Caution,
    random: Random,
    dt_s: f64,
    /// Heading in the odometry frame, and for how many ticks more.
    desired_heading_rad: f64,
    keep_ticks: u64,
    /// The direction that was free at the last scan, odometry frame.
    course_rad: f64,
}

/// Makes a driver that wanders. It begins without a wish: the first scan makes one.
pub fn driver(start: &Start, options: Options) -> Driver<Reckoning, Wander> {
    let task = Wander {
        caution: options.caution,
        random: Random::new(options.seed, 1),
        dt_s: start.dt_s,
        desired_heading_rad: 0.0,
        keep_ticks: 0,
        course_rad: 0.0,
    };
    let filter = Reckoning::new(start, options.odometry);
    Driver::new(start, &options.caution, filter, task)
}

impl Wander {
    /// Draws a wish: a sector by the square of how far it is free.
    fn choose_heading(&mut self, around: &Surroundings, heading_rad: f64) {
        let weights = || sectors(around).map(|(rad, far_m)| (rad, far_m * far_m));
        let all: f64 = weights().map(|(_, weight)| weight).sum();
        let mut left = all * self.random.uniform();
        let share = self.random.uniform();
        let chosen = weights().find(|(_, weight)| {
            left -= weight;
            left < 0.0
        });
        // Where nothing is free anywhere, it turns round.
        let bearing_rad = chosen.map_or(std::f64::consts::PI, |(rad, _)| rad);
        self.desired_heading_rad = wrap_angle(heading_rad + bearing_rad);
        let kept_s = KEPT_S[0] + (KEPT_S[1] - KEPT_S[0]) * share;
        self.keep_ticks = (kept_s / self.dt_s).ceil() as u64;
    }
}

impl Task<Reckoning> for Wander {
    fn is_done(&self) -> bool {
        false
    }

    fn command(&mut self, pilot: &mut Pilot, known: &Known<'_, Reckoning>) -> Twist {
        let around = pilot.around();
        let heading_rad = around.pose_in_odometry().theta();
        self.keep_ticks = self.keep_ticks.saturating_sub(1);
        if known.ranges_m.is_some() {
            let desired_rad = wrap_angle(self.desired_heading_rad - heading_rad);
            if self.keep_ticks == 0 || around.clear_towards_m(desired_rad, 0.0) < END_M {
                self.choose_heading(around, heading_rad);
            }
            let desired_rad = wrap_angle(self.desired_heading_rad - heading_rad);
            let (free_rad, _) = free_direction(around, desired_rad, END_M);
            self.course_rad = heading_rad + free_rad;
        }
        let bearing_rad = wrap_angle(self.course_rad - heading_rad);
        steer(around, bearing_rad, &self.caution)
    }

    /// Prints the reason if the robot never moved.
    fn finish(self, name: &str, pilot: &Pilot, _: &Reckoning) -> Result<(), ClientError> {
        match pilot.around().remark() {
            "" => {}
            remark => errln!("{name}: stood{remark}"),
        }
        Ok(())
    }
}
