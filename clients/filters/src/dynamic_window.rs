//! The dynamic window approach: of all speeds and turn rates that the robot can have
//! after the next moment, the one that looks best.
//!
//! Source: D. Fox, W. Burgard, S. Thrun, *The dynamic window approach to collision
//! avoidance* (IEEE Robotics & Automation Magazine 4(1), 1997): circles only (§III-A),
//! admissible speeds, from which the robot can stop before the first obstacle of the
//! circle (equation 14), the window of what the accelerations allow (equation 15), and
//! the weighted sum of heading, distance and speed (equation 13).
//!
//! Departures, and why:
//! * The target is the aim on the planned way ([`crate::pursuit`]), a moment ahead, and
//!   not the goal, and where the straight way to it is blocked, the free direction nearest
//!   to it ([`crate::steering`]): the method alone stays behind the next wall or person.
//! * Distance has a weight of 0.05 and not 0.2, next to 2.0 of heading and 0.2 of speed
//!   (§V-A): in corridors and doors of a metre it held the robot back.
//! * The three terms are not smoothed, and the distance counts up to 1.5 m: beyond it
//!   every way is free.
//! * A decision is made at each scan and holds until the next. What is executed is also
//!   limited by [`Surroundings::limit`] in each tick, the rule of every driver.
//! * Obstacles are those of the last seconds, where they were seen. People move on; the
//!   place behind them stays blocked until the scans are forgotten (`--memory-s`).

use clap::Args;
use nalgebra::{Point2, Vector3};
use rusty_geometry::{SE2, Twist, trig};

use crate::numbers::positive;
use crate::pursuit::{Aim, end_speed_m_s};
use crate::steering::{NEED_M, free_direction};
use crate::surroundings::{Caution, Surroundings};

/// Weights of heading, distance and speed.
const HEADING: f64 = 2.0;
const DISTANCE: f64 = 0.05;
const SPEED: f64 = 0.2;

/// Speeds and turn rates in the window, each.
const SPEEDS: u32 = 8;
const TURNS: u32 = 21;

/// From here on more room does not count, m.
const FAR_M: f64 = 1.5;

/// The heading is compared with the aim's direction after this time, s: the cycle of the
/// paper.
const AHEAD_S: f64 = 0.25;

/// How fast the robot may change its motion.
#[derive(Args, Clone, Copy, Debug, PartialEq)]
#[command(next_help_heading = "Dynamic window")]
pub struct Acceleration {
    /// Maximum acceleration of --local dwa, m/s²
    #[arg(long, value_name = "ACCELERATION", default_value_t = 0.5, value_parser = positive)]
    pub accel_m_s2: f64,

    /// Maximum acceleration of the turn rate of --local dwa, rad/s²
    #[arg(long, value_name = "ACCELERATION", default_value_t = 3.0, value_parser = positive)]
    pub turn_accel_rad_s2: f64,
}

crate::numbers::default_of_command_line!(Acceleration);

/// Chooses commands one after the other.
#[derive(Clone, Copy, Debug)]
pub struct DynamicWindow {
    most: Acceleration,
    /// What was decided, and how long ago, s.
    decided: Twist,
    since_s: f64,
}

/// How a command looks, each from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Looks {
    heading: f64,
    distance: f64,
    speed: f64,
}

impl Looks {
    fn sum(&self) -> f64 {
        HEADING * self.heading + DISTANCE * self.distance + SPEED * self.speed
    }
}

impl DynamicWindow {
    /// Of a robot that stands.
    pub fn new(most: Acceleration) -> Self {
        Self { most, decided: Twist::default(), since_s: 0.0 }
    }

    /// The command for the next tick, of `dt_s`, towards an aim; decided anew if a scan
    /// has come.
    pub fn command(
        &mut self,
        around: &Surroundings,
        aim: &Aim,
        caution: &Caution,
        dt_s: f64,
    ) -> Twist {
        self.since_s += dt_s;
        if around.is_new() {
            self.decided = self.decide(around, aim, caution);
            self.since_s = 0.0;
        }
        let given = around.limit(self.decided);
        // A robot that was stopped starts from there.
        if given.v_m_s < self.decided.v_m_s {
            self.decided = given;
        }
        given
    }

    /// The robot was stopped from elsewhere.
    pub fn stop(&mut self) {
        self.decided = Twist::default();
    }

    fn decide(&self, around: &Surroundings, aim: &Aim, caution: &Caution) -> Twist {
        let target = target(around, aim);
        let most_m_s = caution.speed_m_s.min(end_speed_m_s(aim.left_m + aim.off_m));
        let most_rad_s = caution.turn_rad_s;
        let speeds = window(self.decided.v_m_s, self.most.accel_m_s2 * self.since_s, 0.0, most_m_s);
        let turn = self.most.turn_accel_rad_s2 * self.since_s;
        let turns = window(self.decided.omega_rad_s, turn, -most_rad_s, most_rad_s);
        let mut best: Option<(f64, Twist)> = None;
        for omega_rad_s in steps(turns, TURNS) {
            for v_m_s in steps(speeds, SPEEDS) {
                let twist = Twist { v_m_s, omega_rad_s };
                let Some(looks) = self.looks(around, &target, twist, caution) else { continue };
                if best.is_none_or(|(sum, _)| looks.sum() > sum) {
                    best = Some((looks.sum(), twist));
                }
            }
        }
        // Nothing in the window can be stopped in time: it stops as fast as it can.
        best.map_or(Twist::default(), |(_, twist)| twist)
    }

    /// How a command looks for a target in the body frame; `None` where the robot could
    /// not stop in time.
    fn looks(
        &self,
        around: &Surroundings,
        target: &Point2<f64>,
        twist: Twist,
        caution: &Caution,
    ) -> Option<Looks> {
        let clear_m = match twist.v_m_s == 0.0 {
            true => FAR_M,
            false => around.clear_within_m(twist, FAR_M),
        };
        if twist.v_m_s * twist.v_m_s > 2.0 * clear_m * self.most.accel_m_s2 {
            return None;
        }
        let motion = Vector3::new(twist.v_m_s, 0.0, twist.omega_rad_s) * AHEAD_S;
        let there = SE2::identity().boxplus(&motion);
        let seen = there.inverse().transform_point(target);
        let off_rad = trig::atan2(seen.y, seen.x).abs();
        Some(Looks {
            heading: 1.0 - off_rad / std::f64::consts::PI,
            distance: clear_m / FAR_M,
            speed: twist.v_m_s / caution.speed_m_s,
        })
    }
}

/// Where to look to, body frame: the aim, or as far away in the free direction nearest to
/// it.
fn target(around: &Surroundings, aim: &Aim) -> Point2<f64> {
    let far_m = aim.in_body.coords.norm();
    let (free_rad, clear_m) = free_direction(around, aim.bearing_rad(), far_m.min(NEED_M));
    if clear_m <= 0.0 {
        return aim.in_body;
    }
    let (s, c) = trig::sin_cos(free_rad);
    Point2::new(far_m * c, far_m * s)
}

/// What is within reach of `now`, and allowed; where nothing is, the allowed value that
/// is nearest.
fn window(now: f64, reach: f64, least: f64, most: f64) -> [f64; 2] {
    [(now - reach).clamp(least, most), (now + reach).clamp(least, most)]
}

/// `count` values from one end of a window to the other.
fn steps([from, to]: [f64; 2], count: u32) -> impl Iterator<Item = f64> {
    let of = move |k: u32| from + (to - from) * f64::from(k) / f64::from(count - 1);
    (0..count).map(of)
}

#[cfg(test)]
#[path = "dynamic_window_tests.rs"]
mod tests;
