//! How long a driver holds back its answer to a tick.
//!
//! The command of a tick is in the answer to the tick before it. At a pace, the run stands
//! still between two ticks, and a driver that answers at once gives a command that is as
//! old as a tick is long. One that answers shortly before the next tick is due gives a
//! newer one, and the run is as fast as before.

use std::time::Duration;

/// Time between the answer and the next tick: the run needs some of it.
const REST: Duration = Duration::from_millis(3);
/// Longest time by which an answer is held back, s.
const MOST_S: f64 = 0.05;
/// The same as a part of the duration of a tick.
const MOST_OF_TICK: f64 = 0.85;

/// The time by which the answers of a run are held back at most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hold {
    most: Duration,
}

impl Hold {
    /// Of a run whose ticks last this long.
    #[must_use]
    pub fn new(dt_s: f64) -> Self {
        Self { most: Duration::from_secs_f64((MOST_OF_TICK * dt_s).clamp(0.0, MOST_S)) }
    }

    /// Returns the time by which to hold back the answer to a tick that came this long
    /// after the one before. It is zero at full speed, and soon after a pause is over.
    #[must_use]
    pub fn after(self, interval: Duration) -> Duration {
        interval.saturating_sub(REST).min(self.most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_answer_is_held_back_at_a_pace_and_not_at_full_speed() {
        let held_ms = |dt_s: f64, interval_ms: u64| {
            Hold::new(dt_s).after(Duration::from_millis(interval_ms)).as_secs_f64() * 1e3
        };
        // Real time, half of it, twice as fast, ten times as fast.
        let ms = [20, 40, 10, 2].map(|interval_ms| held_ms(0.02, interval_ms).round());
        assert_eq!(ms, [17.0, 17.0, 7.0, 0.0]);
        // Long ticks, and a pause before the tick.
        assert_eq!([held_ms(0.1, 100), held_ms(0.02, 60_000)], [50.0, 17.0]);
        assert_eq!(held_ms(1e300, 100), 50.0);
    }

    #[test]
    fn after_a_pause_a_run_is_soon_at_full_speed_again() {
        let hold = Hold::new(0.02);
        let mut interval = Duration::from_secs(60);
        let mut held = Vec::new();
        for _ in 0..6 {
            let time = hold.after(interval);
            held.push(time.as_millis());
            // Others answer within a millisecond.
            interval = time.max(Duration::from_millis(1));
        }
        assert_eq!(held, [17, 14, 11, 8, 5, 2]);
    }
}
