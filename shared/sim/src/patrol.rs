//! The patrol: up and down a corridor on a timetable, open loop.
//!
//! A first straight, then for ever: stand, turn in place, a long straight. A
//! straight of n ticks drives v·(q + 1)/(ramp + 1) in tick j while
//! q = min(j, n − 1 − j) is below the ramp, else v.
//!
//! Source: the patrol of chapter 4 of the online *Probabilistic Robotics*, whose
//! script is not published; this timetable and its default numbers were found by
//! a search for one that is consistent with every printed digit. Matching is
//! selection, not recovery.

use rusty_contract::config::PatrolConfig;
use rusty_geometry::Twist;

/// A patrol's timetable in whole ticks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patrol {
    v_m_s: f64,
    omega_rad_s: f64,
    ramp: u64,
    first: u64,
    pause: u64,
    turn: u64,
    leg: u64,
}

impl Patrol {
    /// The patrol of `config` in ticks of `dt_s` seconds, each time rounded to
    /// whole ticks. The configuration must be checked, as part of its
    /// [`ScriptConfig`](rusty_contract::ScriptConfig::check).
    #[must_use]
    pub fn new(config: &PatrolConfig, dt_s: f64) -> Self {
        Self {
            v_m_s: config.v_m_s,
            omega_rad_s: config.omega_rad_s,
            ramp: whole_ticks(config.ramp_s, dt_s),
            first: whole_ticks(config.first_s, dt_s),
            pause: whole_ticks(config.pause_s, dt_s),
            turn: whole_ticks(config.turn_s, dt_s),
            leg: whole_ticks(config.leg_s, dt_s),
        }
    }

    /// The command of tick `tick`, body frame. Once the first straight is over,
    /// a patrol whose every part was rounded to nothing stands.
    #[must_use]
    pub fn command_at(&self, tick: u64) -> Twist {
        if tick < self.first {
            return self.straight(tick, self.first);
        }
        let round = self.pause + self.turn + self.leg;
        let Some(u) = (tick - self.first).checked_rem(round) else {
            return Twist::default();
        };
        if u < self.pause {
            Twist::default()
        } else if u < self.pause + self.turn {
            Twist { v_m_s: 0.0, omega_rad_s: self.omega_rad_s }
        } else {
            self.straight(u - self.pause - self.turn, self.leg)
        }
    }

    /// Tick `j` of a straight of `n` ticks, `j` below `n`.
    fn straight(&self, j: u64, n: u64) -> Twist {
        let q = j.min(n - 1 - j);
        let v_m_s = if q < self.ramp {
            self.v_m_s * (q + 1) as f64 / (self.ramp + 1) as f64
        } else {
            self.v_m_s
        };
        Twist { v_m_s, omega_rad_s: 0.0 }
    }
}

/// `time_s` in whole ticks of `dt_s`, halves away from zero.
pub(crate) fn whole_ticks(time_s: f64, dt_s: f64) -> u64 {
    // The cast saturates: a negative time or NaN is no tick at all.
    (time_s / dt_s).round() as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn script_g() -> Patrol {
        Patrol::new(&PatrolConfig::default(), 0.1)
    }

    #[test]
    fn times_become_the_ticks_of_script_g() {
        let p = script_g();
        let ticks = [p.first, p.leg, p.pause, p.turn, p.ramp];
        assert_eq!(ticks, [23, 123, 3, 10, 6]);
    }

    #[test]
    fn the_timetable_tick_by_tick() {
        let p = script_g();
        let v = |tick| p.command_at(tick).v_m_s;
        // Ramps of six steps at both ends of the first straight.
        assert_eq!(v(0), 0.57 / 7.0);
        assert_eq!(v(5), 0.57 * 6.0 / 7.0);
        assert!((6..17).all(|tick| v(tick) == 0.57));
        assert_eq!((v(17), v(22)), (0.57 * 6.0 / 7.0, 0.57 / 7.0));
        // Stand, turn, and the long leg; then the round again.
        assert!((23..26).all(|tick| p.command_at(tick) == Twist::default()));
        assert!((26..36).all(|tick| p.command_at(tick).omega_rad_s == -3.1363));
        assert_eq!(v(36), 0.57 / 7.0);
        assert_eq!((v(158), v(159)), (0.57 / 7.0, 0.0));
        for tick in 23..159 {
            assert_eq!(p.command_at(tick), p.command_at(tick + 136));
        }
    }

    #[test]
    fn a_straight_shorter_than_its_ramps_never_reaches_full_speed() {
        let p = script_g();
        let v: Vec<f64> = (0..5).map(|j| p.straight(j, 5).v_m_s * 7.0 / 0.57).collect();
        for (found, expected) in v.iter().zip([1.0, 2.0, 3.0, 2.0, 1.0]) {
            assert!((found - expected).abs() < 1e-12);
        }
    }

    #[test]
    fn a_timetable_of_nothing_stands() {
        // Every part shorter than half a tick.
        let p = Patrol::new(&PatrolConfig::default(), 100.0);
        assert_eq!(p.command_at(0), Twist::default());
        assert_eq!(p.command_at(u64::MAX), Twist::default());
    }
}
