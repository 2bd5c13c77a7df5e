//! Noticing that the robot is not where the particles are.
//!
//! Source: *Probabilistic Robotics*, §8.3.5, Table 8.3: two running means of how
//! likely the measurements were, a slow one and a fast one. While the fast one
//! is below the slow one, the share 1 − w_fast / w_slow of the belief is to come
//! from everywhere.
//!
//! Departures, and why:
//! * What is averaged is the likelihood of one beam: the geometric mean over the
//!   beams of a scan. The product over 180 of them changes by powers of ten from
//!   one place to the next, and a mean of such numbers is that of its largest.
//! * Over particles it is the mean by their weights *after* the scan: how well
//!   the belief explains it. The book weighs all alike, wrong ones included. A scan of
//!   a place that has had one changes no weights; it is a mean by those there are.
//! * People hide walls. So beams that end in front of all walls of the map do not count
//!   (Table 8.5, which leaves them out of the likelihoods as well), at most two thirds of a scan:
//!   in a room that is smaller than the one where it is believed to be, a robot sees no others.
//! * Where the robot may be anywhere at the beginning, the slow mean begins at
//!   what the sensor model expects of a right pose. The book begins both with
//!   what comes first; a filter that settled in a wrong place right away would
//!   never know of a better one.
//! * Where a search of the whole map found nothing better, the slow mean comes
//!   down by half of the way, in its logarithm: a map drawn by a robot explains
//!   even the right pose less well than a model of the laser alone expects.

/// How fast the slow mean follows, per scan.
const ALPHA_SLOW: f64 = 0.002;
/// How fast the fast mean follows, per scan.
const ALPHA_FAST: f64 = 0.1;

/// The most beams of a scan that may be of something in front of the walls.
const MOST_HIDDEN: f64 = 2.0 / 3.0;

/// How many of `all` beams do not count, of which `in_front` end in front of all walls.
pub(crate) fn hidden(in_front: f64, all: f64) -> f64 {
    in_front.min(MOST_HIDDEN * all)
}

/// The two means of Table 8.3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Recovery {
    w_slow: f64,
    w_fast: f64,
}

impl Recovery {
    /// Begins without an opinion: the first scan is as good as can be expected.
    pub fn trusting() -> Self {
        Self { w_slow: 0.0, w_fast: 0.0 }
    }

    /// Begins lost: nothing was explained yet, and `expected` is the likelihood
    /// of a beam at the right pose.
    pub fn lost(expected: f64) -> Self {
        Self { w_slow: expected, w_fast: 0.0 }
    }

    /// Takes the mean likelihood of a beam in one more scan.
    pub fn update(&mut self, w: f64) {
        if self.w_slow == 0.0 {
            *self = Self { w_slow: w, w_fast: w };
            return;
        }
        self.w_slow += ALPHA_SLOW * (w - self.w_slow);
        self.w_fast += ALPHA_FAST * (w - self.w_fast);
    }

    /// The robot was found elsewhere, where a beam has this likelihood.
    pub fn found(&mut self, w: f64) {
        self.w_fast = w;
    }

    /// The robot was looked for everywhere, and nothing better was found.
    pub fn allay(&mut self) {
        self.w_slow = (self.w_slow * self.w_fast).sqrt();
    }

    /// Which share of the belief is to come from everywhere.
    pub fn share(&self) -> f64 {
        if self.w_slow > 0.0 { (1.0 - self.w_fast / self.w_slow).clamp(0.0, 1.0) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_means_are_those_of_the_table() {
        let mut recovery = Recovery::trusting();
        recovery.update(10.0);
        assert_eq!((recovery, recovery.share()), (Recovery { w_slow: 10.0, w_fast: 10.0 }, 0.0));
        recovery.update(4.0);
        // By hand: 10 + 0.002 · (4 − 10), 10 + 0.1 · (4 − 10).
        assert!((recovery.w_slow - 9.988).abs() < 1e-12 && (recovery.w_fast - 9.4).abs() < 1e-12);
        assert!((recovery.share() - (1.0 - 9.4 / 9.988)).abs() < 1e-12);
        // What goes on like that is taken for the rule.
        (0..20_000).for_each(|_| recovery.update(4.0));
        assert!(recovery.share() < 1e-6, "{recovery:?}");
        // Better than ever is no reason for doubt.
        recovery.update(9.0);
        assert_eq!(recovery.share(), 0.0);
    }

    #[test]
    fn a_search_in_vain_takes_half_of_the_doubt_away() {
        let mut recovery = Recovery { w_slow: 8.0, w_fast: 2.0 };
        recovery.allay();
        assert_eq!((recovery.w_slow, recovery.share()), (4.0, 0.5));
    }

    #[test]
    fn who_begins_lost_stays_so_until_the_scans_fit() {
        let mut recovery = Recovery::lost(10.0);
        assert_eq!(recovery.share(), 1.0);
        (0..20).for_each(|_| recovery.update(1.0));
        assert!(recovery.share() > 0.8, "{recovery:?}");
        (0..60).for_each(|_| recovery.update(10.0));
        assert!(recovery.share() < 0.02, "{recovery:?}");
    }
}
