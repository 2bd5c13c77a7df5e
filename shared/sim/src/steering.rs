//! Steering: keeps a patrol in its corridor by looking at the true pose.
//!
//! Walls spoil an open-loop patrol: with slip, more than half of all runs touch
//! one. So the server may steer on the truth, which it alone knows; the commands
//! that come out are ordinary commands in frame and log. With the gains below, a
//! client computes the true pose from them: no built-in scenario is steered so.
//!
//! With the nominal pose p_n (the timetable integrated without noise from the
//! start, as it is before the tick), the true pose (p, θ), e = R(−θ)(p_n − p) and
//! e_θ = θ_n − θ wrapped:
//!
//! v = v_n + e_x (only where v_n > 0), ω = ω_n + 1.5·e_θ + 2·e_y·v_n.
//!
//! Source: the usual tracking law for a unicycle (Y. Kanayama et al., *A stable
//! tracking control method for an autonomous mobile robot*, ICRA 1990), made
//! linear in e_θ, with other gains.

use rusty_geometry::{SE2, Twist, wrap_angle};

use crate::patrol::Patrol;

/// Gain of the distance along the heading, 1/s.
const ALONG_PER_S: f64 = 1.0;
/// Gain of the heading error, 1/s.
const HEADING_PER_S: f64 = 1.5;
/// Gain of the distance across the heading, rad/m².
const ACROSS_RAD_PER_M2: f64 = 2.0;

/// A patrol and the pose it should have by now.
#[derive(Clone, Debug)]
pub struct Steering {
    patrol: Patrol,
    dt_s: f64,
    start: SE2,
    /// Pose before tick `nominal_tick` if everything went as planned.
    nominal_in_world: SE2,
    nominal_tick: u64,
}

impl Steering {
    /// Steering for `patrol` in ticks of `dt_s` seconds from `start`, world frame.
    #[must_use]
    pub fn new(patrol: Patrol, dt_s: f64, start: SE2) -> Self {
        Self { patrol, dt_s, start, nominal_in_world: start, nominal_tick: 0 }
    }

    /// The command of tick `tick`, body frame, for a robot whose pose before
    /// that tick is `truth`, world frame. It depends on these two alone: asking
    /// again or out of order only costs time.
    #[must_use]
    pub fn command_at(&mut self, tick: u64, truth: &SE2) -> Twist {
        self.plan_up_to(tick);
        let plan = self.patrol.command_at(tick);
        let error = truth.inverse().compose(&self.nominal_in_world);
        let heading_rad = wrap_angle(self.nominal_in_world.theta() - truth.theta());
        let along_m_s = if plan.v_m_s > 0.0 { ALONG_PER_S * error.x() } else { 0.0 };
        Twist {
            v_m_s: plan.v_m_s + along_m_s,
            omega_rad_s: plan.omega_rad_s
                + HEADING_PER_S * heading_rad
                + ACROSS_RAD_PER_M2 * error.y() * plan.v_m_s,
        }
    }

    /// Brings the nominal pose to the beginning of `tick`.
    fn plan_up_to(&mut self, tick: u64) {
        if tick < self.nominal_tick {
            (self.nominal_in_world, self.nominal_tick) = (self.start, 0);
        }
        while self.nominal_tick < tick {
            let plan = self.patrol.command_at(self.nominal_tick);
            let tau =
                nalgebra::Vector3::new(plan.v_m_s * self.dt_s, 0.0, plan.omega_rad_s * self.dt_s);
            self.nominal_in_world = self.nominal_in_world.boxplus(&tau);
            self.nominal_tick += 1;
        }
    }
}
