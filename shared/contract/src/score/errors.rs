//! The errors of one estimator, tick by tick, and the figures they come to.
//!
//! Here and not with the scorer, because whoever simulates many runs at once
//! must come to the same bits: sums are taken in the order of the ticks.
//!
//! Source: M. Grupp, *evo* (Python package, 1.38.1), `evo_ape --pose_relation
//! trans_part` without alignment, for planar poses.

use rusty_geometry::{SE2, trig, wrap_angle};
use serde::{Deserialize, Serialize};

use super::quantile::Quantiles;

/// Distance between an estimate and its truth, m.
#[must_use]
pub fn position_error_m(estimate: &SE2, truth: &SE2) -> f64 {
    trig::hypot(estimate.x() - truth.x(), estimate.y() - truth.y())
}

/// Heading of the estimate less heading of the truth, rad in (−π, π].
#[must_use]
pub fn heading_error_rad(estimate: &SE2, truth: &SE2) -> f64 {
    wrap_angle(estimate.theta() - truth.theta())
}

/// Length of a path: the sum of the straight steps from each pose to the next,
/// those left out in which the robot was carried.
#[derive(Clone, Debug, Default)]
pub struct PathLength {
    last: Option<SE2>,
    sum_m: f64,
    carried_at: Vec<u64>,
    next_carried: usize,
}

impl PathLength {
    /// The path of a robot that starts at this pose, where it is known, and is
    /// carried elsewhere at the start of these ticks, in order. Without a start the
    /// path begins with the first pose.
    #[must_use]
    pub fn new(start: Option<SE2>, carried_at: Vec<u64>) -> Self {
        Self { last: start, carried_at, ..Self::default() }
    }

    /// The path goes on to this pose, at the end of `tick`.
    pub fn push(&mut self, tick: u64, pose: &SE2) {
        while self.carried_at.get(self.next_carried).is_some_and(|at| *at <= tick) {
            self.next_carried += 1;
            self.last = None;
        }
        if let Some(last) = &self.last {
            let step_m = position_error_m(last, pose);
            // Poses that are numbers may be too far apart for one.
            if (self.sum_m + step_m).is_finite() {
                self.sum_m += step_m;
            }
        }
        self.last = Some(*pose);
    }

    /// The length up to here, m.
    #[must_use]
    pub fn metres(&self) -> f64 {
        self.sum_m
    }
}

/// Errors, tick by tick. Cleared, it serves the next run without allocating.
#[derive(Clone, Debug, Default)]
pub struct Errors {
    position_m: Quantiles,
    position_sum_m: f64,
    position_square_sum_m2: f64,
    position_max_m: f64,
    heading_square_sum_rad2: f64,
    max_heading_error_rad: f64,
    last: [f64; 2],
}

/// What errors come to; `None` of each without a single one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Figures {
    /// The last position error, m.
    pub final_position_error_m: Option<f64>,
    /// The last heading error, rad, 0 to π.
    pub final_heading_error_rad: Option<f64>,
    /// Mean position error, m.
    pub mean_position_error_m: Option<f64>,
    /// 95th percentile of it, m (linear between ranks; of more than a million
    /// ticks as good as [`Quantiles`] is).
    pub p95_position_error_m: Option<f64>,
    /// The greatest, m.
    pub max_position_error_m: Option<f64>,
    /// Root of its mean square, m.
    pub ate_rmse_m: Option<f64>,
    /// Root of the mean square of the heading error, rad.
    pub rmse_heading_error_rad: Option<f64>,
    /// The greatest heading error, rad, 0 to π.
    pub max_heading_error_rad: Option<f64>,
}

impl Errors {
    /// None yet, with room for as many ticks as are expected.
    #[must_use]
    pub fn expecting(ticks: u64) -> Self {
        Self { position_m: Quantiles::expecting(ticks), ..Self::default() }
    }

    /// Takes the next tick: an estimate and the truth it is held against, both
    /// made of finite numbers.
    pub fn push(&mut self, estimate: &SE2, truth: &SE2) {
        let position_m = position_error_m(estimate, truth);
        let heading_rad = heading_error_rad(estimate, truth).abs();
        self.position_m.push(position_m);
        self.position_sum_m += position_m;
        self.position_square_sum_m2 += position_m * position_m;
        self.heading_square_sum_rad2 += heading_rad * heading_rad;
        if position_m > self.position_max_m {
            self.position_max_m = position_m;
        }
        if heading_rad > self.max_heading_error_rad {
            self.max_heading_error_rad = heading_rad;
        }
        self.last = [position_m, heading_rad];
    }

    /// Ticks taken.
    #[must_use]
    pub fn ticks(&self) -> u64 {
        self.position_m.count()
    }

    /// Forgets all of it, but not the room it needs.
    pub fn clear(&mut self) {
        let mut position_m = std::mem::take(&mut self.position_m);
        position_m.clear();
        *self = Self { position_m, ..Self::default() };
    }

    /// Median of the position error, m, as good as [`Quantiles`] is; `None`
    /// without a tick. Changes the order in which they are kept.
    pub fn median_m(&mut self) -> Option<f64> {
        self.position_m.at(0.5)
    }

    /// What they come to. Changes the order in which they are kept, and
    /// nothing else: more may follow.
    pub fn figures(&mut self) -> Figures {
        let count = self.ticks() as f64;
        let some = |value: f64| (count > 0.0).then_some(value);
        Figures {
            final_position_error_m: some(self.last[0]),
            final_heading_error_rad: some(self.last[1]),
            mean_position_error_m: some(self.position_sum_m / count),
            p95_position_error_m: self.position_m.at(0.95),
            max_position_error_m: some(self.position_max_m),
            ate_rmse_m: some((self.position_square_sum_m2 / count).sqrt()),
            rmse_heading_error_rad: some((self.heading_square_sum_rad2 / count).sqrt()),
            max_heading_error_rad: some(self.max_heading_error_rad),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn by_hand_and_once_more_after_clearing() {
        let truth = SE2::new(0.0, 0.0, 3.0);
        let mut errors = Errors::default();
        assert_eq!(errors.figures(), Figures::default());
        for _ in 0..2 {
            errors.clear();
            errors.push(&SE2::new(3.0, 4.0, -3.0), &truth);
            errors.push(&SE2::new(0.0, 1.0, 3.0), &truth);
            let figures = errors.figures();
            assert_eq!(figures.final_position_error_m, Some(1.0));
            assert_eq!(figures.final_heading_error_rad, Some(0.0));
            assert_eq!(
                (figures.mean_position_error_m, figures.max_position_error_m),
                (Some(3.0), Some(5.0))
            );
            assert_eq!(figures.ate_rmse_m, Some(13f64.sqrt()));
            // Across the half turn: 2π − 6, not 6.
            let turn_rad = std::f64::consts::TAU - 6.0;
            assert!((figures.max_heading_error_rad.unwrap() - turn_rad).abs() < 1e-15);
        }
    }

    #[test]
    fn a_path_begins_with_its_first_pose() {
        let mut path = PathLength::default();
        path.push(0, &SE2::new(7.0, 7.0, 0.0));
        assert_eq!(path.metres(), 0.0);
        path.push(1, &SE2::new(10.0, 11.0, 0.0));
        path.push(2, &SE2::new(10.0, 11.0, 1.0));
        assert_eq!(path.metres(), 5.0);
    }

    #[test]
    fn a_path_from_a_known_start_has_the_first_tick() {
        let mut path = PathLength::new(Some(SE2::identity()), Vec::new());
        path.push(0, &SE2::new(3.0, 4.0, 0.0));
        assert_eq!(path.metres(), 5.0);
        // Carried before it drove.
        let mut carried = PathLength::new(Some(SE2::identity()), vec![0]);
        carried.push(0, &SE2::new(3.0, 4.0, 0.0));
        assert_eq!(carried.metres(), 0.0);
    }

    #[test]
    fn who_is_carried_does_not_drive() {
        // Ticks 3 and 4 are of one gap between known poses.
        let mut path = PathLength::new(None, vec![3, 4, 7]);
        for (tick, x_m) in [(0, 0.0), (2, 1.0), (5, 50.0), (6, 52.0), (7, 0.0), (8, 3.0)] {
            path.push(tick, &SE2::new(x_m, 0.0, 0.0));
        }
        assert_eq!(path.metres(), 6.0);
    }
}
