//! How soon a robot was at a list of goals, by its true pose.

use nalgebra::Point2;
use rusty_contract::score::GoalScore;
use rusty_geometry::SE2;

/// A list of goals, which are reached in order.
#[derive(Clone, Debug, Default)]
pub struct Goals {
    /// m, world frame.
    goals: Vec<Point2<f64>>,
    within_m: f64,
    reached: usize,
    /// Time and distance driven when the last was reached, s and m.
    done: Option<[f64; 2]>,
}

impl Goals {
    /// Goals in the world frame, m; each is reached at a distance of at most `within_m`.
    #[must_use]
    pub fn new(goals: Vec<Point2<f64>>, within_m: f64) -> Self {
        Self { goals, within_m, ..Self::default() }
    }

    /// A tick with its true pose at the end, where known: its time, and the distance driven
    /// up to then. A goal that is passed before the one in front of it does not count.
    pub fn push(&mut self, time_s: f64, truth: Option<SE2>, driven_m: f64) {
        let Some(truth) = truth else { return };
        let is_at =
            |goal: &Point2<f64>| (truth.translation() - goal.coords).norm() <= self.within_m;
        if self.goals.get(self.reached).is_some_and(is_at) {
            self.reached += 1;
            self.done = (self.reached == self.goals.len()).then_some([time_s, driven_m]);
        }
    }

    /// Returns what was reached; `None` without a goal.
    #[must_use]
    pub fn score(&self) -> Option<GoalScore> {
        (!self.goals.is_empty()).then(|| GoalScore {
            goals: self.goals.len(),
            reached: self.reached,
            after_s: self.done.map(|[time_s, _]| time_s),
            driven_m: self.done.map(|[_, driven_m]| driven_m),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn goals_are_reached_in_order_and_by_the_true_pose() {
        assert_eq!(Goals::default().score(), None);
        let mut goals = Goals::new(vec![Point2::new(2.0, 0.0), Point2::new(0.0, 1.0)], 0.25);
        let at = |x: f64, y: f64| Some(SE2::new(x, y, 0.3));
        // The second goal is passed first, a tick has no truth, and 0.26 m are too many.
        let way = [at(0.0, 1.0), None, at(2.0, 0.26), at(2.0, -0.25), at(1.0, 1.0)];
        for (tick, truth) in way.into_iter().enumerate() {
            goals.push(tick as f64, truth, 2.0 * tick as f64);
        }
        let score = GoalScore { goals: 2, reached: 1, after_s: None, driven_m: None };
        assert_eq!(goals.score(), Some(score));
        goals.push(5.0, at(0.1, 0.9), 10.0);
        goals.push(6.0, at(2.0, 0.0), 12.0);
        let score = GoalScore { reached: 2, after_s: Some(5.0), driven_m: Some(10.0), ..score };
        assert_eq!(goals.score(), Some(score));
    }
}
