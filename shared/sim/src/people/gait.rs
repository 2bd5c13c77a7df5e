//! The gait: two legs that swing with the distance walked.
//!
//! Departures from real walking: the legs are discs that swing sinusoidally and in
//! opposite phase along the direction of walking; one who stands keeps both together.

use nalgebra::{Point2, Vector2};
use rusty_geometry::{Disc, trig};

use super::force::length;

/// Radius of a leg, m.
const LEG_M: f64 = 0.06;
/// Distance of each leg from the middle, sideways, m.
const ASIDE_M: f64 = 0.1;
/// Greatest distance of each leg from the middle, ahead and behind, m.
const SWING_M: f64 = 0.2;
/// Way of a whole cycle of two steps, m.
const STRIDE_M: f64 = 1.4;

/// How far a leg reaches from the middle at most, m.
pub(super) const REACH_M: f64 = 0.284;

/// Where in the cycle a walker is, and where they are going.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Gait {
    bearing_rad: f64,
    phase_rad: f64,
    swing: f64,
}

impl Gait {
    /// Goes on by a step.
    pub fn walk(&mut self, velocity_m_s: &Vector2<f64>, dt_s: f64) {
        let speed_m_s = length(velocity_m_s);
        if speed_m_s > 0.0 {
            self.bearing_rad = trig::atan2(velocity_m_s.y, velocity_m_s.x);
        }
        let turn = std::f64::consts::TAU;
        self.phase_rad = (self.phase_rad + turn * speed_m_s * dt_s / STRIDE_M) % turn;
        self.swing = SWING_M * (speed_m_s / 1.0).min(1.0);
    }

    /// Stops, with both legs together.
    pub fn stand(&mut self) {
        self.swing = 0.0;
    }

    /// The left leg and the right one.
    pub fn legs(&self, at: Point2<f64>) -> [Disc; 2] {
        let (s, c) = trig::sin_cos(self.bearing_rad);
        let ahead = Vector2::new(c, s);
        let left = Vector2::new(-ahead.y, ahead.x);
        let swing = ahead * (self.swing * trig::sin(self.phase_rad));
        [
            Disc { centre: at + left * ASIDE_M + swing, radius_m: LEG_M },
            Disc { centre: at - left * ASIDE_M - swing, radius_m: LEG_M },
        ]
    }
}
