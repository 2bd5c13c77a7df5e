//! How fast simulated time goes beside the clock on the wall.

use std::time::Duration;

/// How fast simulated time goes. It never changes a bit of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Pace {
    /// As fast as everyone answers.
    #[default]
    Max,
    /// So many simulated seconds per second; 1 is real time.
    Factor(f64),
}

impl Pace {
    /// When tick `tick` is due after the first frame; `None`: at once.
    #[must_use]
    pub fn due(self, tick: u64, dt_s: f64) -> Option<Duration> {
        match self {
            Self::Max => None,
            Self::Factor(factor) => {
                let due = Duration::try_from_secs_f64(tick as f64 * dt_s / factor);
                // Later than the clock can say is never, not at once.
                Some(due.unwrap_or(Duration::MAX))
            }
        }
    }
}

impl std::str::FromStr for Pace {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "max" => Ok(Self::Max),
            "real" => Ok(Self::Factor(1.0)),
            _ => match text.parse::<f64>() {
                Ok(f) if f.is_finite() && f > 0.0 => Ok(Self::Factor(f)),
                _ => Err(format!("{text:?} is no pace; use max, real, or a factor such as 2.5")),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pace_is_a_word_or_a_factor() {
        assert_eq!("max".parse(), Ok(Pace::Max));
        assert_eq!("real".parse(), Ok(Pace::Factor(1.0)));
        assert_eq!("0.5".parse(), Ok(Pace::Factor(0.5)));
        for bad in ["0", "-1", "nan", "inf", "fast"] {
            assert!(bad.parse::<Pace>().is_err(), "{bad}");
        }
        assert_eq!(Pace::Factor(2.0).due(100, 0.02), Some(Duration::from_secs(1)));
    }
}
