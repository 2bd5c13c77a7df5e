//! Length of the way that a robot truly drove.

use rusty_geometry::SE2;

use super::scored::position_error_m;

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

#[cfg(test)]
mod tests {
    use super::*;

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
