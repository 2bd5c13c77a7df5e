//! A moment of a run, in seconds or in ticks after its start.
//!
//! Ticks are for recordings in which time stands still: stamps with few digits are the
//! same for many ticks.

use std::fmt;
use std::str::FromStr;

use crate::numbers::seconds;

/// A moment after the start of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Moment {
    /// In seconds.
    Seconds(f64),
    /// In ticks.
    Ticks(u64),
}

impl FromStr for Moment {
    type Err = String;

    /// Reads `12.5` (seconds) or `400ticks`.
    fn from_str(text: &str) -> Result<Self, String> {
        let of_ticks = text.strip_suffix("ticks").map(|count| count.trim_end().parse());
        let moment = of_ticks.map_or_else(
            || seconds(text).map(Self::Seconds).ok(),
            |count| count.map(Self::Ticks).ok(),
        );
        moment.ok_or_else(|| "give a time in seconds, 0 or more, or a tick as 400ticks".to_owned())
    }
}

impl fmt::Display for Moment {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Seconds(s) => write!(f, "{s} s"),
            Self::Ticks(count) => write!(f, "{count} ticks"),
        }
    }
}

/// How much of a run has passed at the end of a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elapsed {
    /// Seconds.
    pub s: f64,
    /// Ticks.
    pub ticks: u64,
}

impl Elapsed {
    /// Whether a moment is now or was earlier.
    pub fn is_from(&self, moment: Moment) -> bool {
        match moment {
            Moment::Seconds(s) => self.s >= s,
            Moment::Ticks(ticks) => self.ticks >= ticks,
        }
    }

    /// Whether a moment is now or comes later.
    pub fn is_until(&self, moment: Moment) -> bool {
        match moment {
            Moment::Seconds(s) => self.s <= s,
            Moment::Ticks(ticks) => self.ticks <= ticks,
        }
    }
}

/// Counts what has passed of a run, from the first tick that is told.
#[derive(Clone, Debug, Default)]
pub struct RunClock {
    began_s: Option<f64>,
    ticks: u64,
}

impl RunClock {
    /// A tick ends at `time_s`. If it is the first one, it took `dt_s`.
    pub fn tick(&mut self, time_s: f64, dt_s: f64) -> Elapsed {
        self.ticks += 1;
        Elapsed { s: time_s - *self.began_s.get_or_insert(time_s - dt_s), ticks: self.ticks }
    }

    /// Whether a tick was told.
    pub fn is_running(&self) -> bool {
        self.began_s.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_moment_is_seconds_or_ticks() {
        for (text, moment, shown) in [
            ("12.5", Moment::Seconds(12.5), "12.5 s"),
            ("0", Moment::Seconds(0.0), "0 s"),
            ("400ticks", Moment::Ticks(400), "400 ticks"),
            ("400 ticks", Moment::Ticks(400), "400 ticks"),
        ] {
            assert_eq!(text.parse(), Ok(moment));
            assert_eq!(moment.to_string(), shown);
        }
        for text in ["", "-1", "NaN", "inf", "ticks", "-3ticks", "1.5ticks", "400tocks"] {
            assert!(text.parse::<Moment>().is_err(), "{text}");
        }
    }

    #[test]
    fn ticks_pass_where_time_stands_still() {
        let mut clock = RunClock::default();
        assert!(!clock.is_running());
        let passed = [7.0, 7.0, 7.0, 8.0].map(|time_s| clock.tick(time_s, 0.5));
        assert!(clock.is_running());
        assert_eq!(passed[2], Elapsed { s: 0.5, ticks: 3 });
        let by = |is: fn(&Elapsed, Moment) -> bool, moment| passed.map(|now| is(&now, moment));
        let second = Moment::Ticks(2);
        assert_eq!(by(Elapsed::is_from, second), [false, true, true, true]);
        assert_eq!(by(Elapsed::is_until, second), [true, true, false, false]);
        let half = Moment::Seconds(0.5);
        assert_eq!(by(Elapsed::is_from, half), [true; 4]);
        assert_eq!(by(Elapsed::is_until, half), [true, true, true, false]);
    }
}
