//! The discrete Bayes filter over a row of cells.
//!
//! Source: *Probabilistic Robotics*, Tables 2.1 and 4.1: predict by the theorem
//! of total probability, correct by Bayes' rule and normalise.
//!
//! Departures, and why:
//! * A motion is a whole number of cells, and what it leaves over is the caller's
//!   to keep. Shifts by parts of a cell blur a histogram a little every time, and
//!   a robot makes many small steps.
//! * A normal error much narrower than a cell has no mass in the neighbouring
//!   cells, however often it is added. The error of a motion is therefore a kernel
//!   of three cells with the right variance: (a, 1 − 2a, a), 2a = σ².

/// The widest variance that one kernel of three cells gives, cells²: half of the
/// mass stays.
const WIDEST: f64 = 0.5;

/// A belief over cells in a row; whatever is done to it, its sum stays 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Histogram {
    cells: Vec<f64>,
}

impl Histogram {
    /// A belief with these weights, made to sum to 1; all the same where that is
    /// impossible.
    pub fn new(weights: Vec<f64>) -> Self {
        let mut histogram = Self { cells: weights };
        if !histogram.normalise() {
            let share = 1.0 / histogram.cells.len().max(1) as f64;
            histogram.cells.fill(share);
        }
        histogram
    }

    /// The mass of each cell.
    pub fn cells(&self) -> &[f64] {
        &self.cells
    }

    /// Corrects by a measurement with this likelihood in each cell (Table 2.1,
    /// line 4). One that is possible in no cell changes nothing, and the
    /// answer is `false`.
    pub fn correct(&mut self, likelihood: impl Fn(usize) -> f64) -> bool {
        let before = self.cells.clone();
        let weighed = self.cells.iter_mut().enumerate();
        weighed.for_each(|(cell, mass)| *mass *= likelihood(cell));
        let possible = self.normalise();
        if !possible {
            self.cells = before;
        }
        possible
    }

    /// Predicts a motion within `row` by this many cells. What would leave the
    /// row stays in its last cell: there is a wall.
    pub fn shift(&mut self, row: std::ops::Range<usize>, by: i64) {
        let row = &mut self.cells[row];
        let Some(last) = row.len().checked_sub(1) else { return };
        let before = row.to_vec();
        row.fill(0.0);
        for (cell, mass) in before.into_iter().enumerate() {
            row[(cell as i64).saturating_add(by).clamp(0, last as i64) as usize] += mass;
        }
    }

    /// Predicts the error of a motion within `row`: spreads every cell by a
    /// variance in cells².
    pub fn spread(&mut self, row: std::ops::Range<usize>, variance: f64) {
        let row = &mut self.cells[row];
        let Some(last) = row.len().checked_sub(1) else { return };
        let times = (variance / WIDEST).ceil().clamp(0.0, 1e4);
        let share = if times > 0.0 { (0.5 * variance / times).min(0.5 * WIDEST) } else { 0.0 };
        for _ in 0..times as usize {
            let before = row.to_vec();
            row.fill(0.0);
            for (cell, mass) in before.into_iter().enumerate() {
                let aside = share * mass;
                row[cell.saturating_sub(1)] += aside;
                row[(cell + 1).min(last)] += aside;
                row[cell] += mass - 2.0 * aside;
            }
        }
    }

    /// Swaps the first half of the cells with the second. The middle one of an odd
    /// number stays.
    pub fn swap_halves(&mut self) {
        let half = self.cells.len() / 2;
        let (first, rest) = self.cells.split_at_mut(half);
        let from = rest.len() - half;
        first.swap_with_slice(&mut rest[from..]);
    }

    /// The cell with the most mass, the first of equal ones.
    pub fn mode(&self) -> usize {
        let more = |best: usize, cell: usize| self.cells[cell] > self.cells[best];
        (0..self.cells.len()).fold(0, |best, cell| if more(best, cell) { cell } else { best })
    }

    fn normalise(&mut self) -> bool {
        let sum: f64 = self.cells.iter().sum();
        let can = sum > 0.0 && sum.is_finite();
        if can {
            self.cells.iter_mut().for_each(|mass| *mass /= sum);
        }
        can
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Random;

    #[test]
    fn the_door_of_chapter_two() {
        // §2.4.2: open or closed, 0.5 each; a camera that says "open" with 0.6 of
        // an open door and 0.2 of a closed one; a push that opens with 0.8.
        let said_open = |cell: usize| [0.6, 0.2][cell];
        let mut belief = Histogram::new(vec![0.5, 0.5]);
        assert!(belief.correct(said_open));
        assert!((belief.cells()[0] - 0.75).abs() < 1e-15, "{belief:?}");
        let [open, closed] = [belief.cells()[0], belief.cells()[1]];
        let mut belief = Histogram::new(vec![open + 0.8 * closed, 0.2 * closed]);
        assert!((belief.cells()[0] - 0.95).abs() < 1e-15, "{belief:?}");
        assert!(belief.correct(said_open));
        assert!((belief.cells()[0] - 0.57 / 0.58).abs() < 1e-15, "{belief:?}");
        assert!((belief.cells()[0] - 0.983).abs() < 5e-4);
    }

    #[test]
    fn a_prediction_is_the_convolution_bin_by_bin() {
        let (count, mut random) = (30, Random::new(4, 1));
        let weights: Vec<f64> = (0..count).map(|_| random.uniform()).collect();
        for (by, variance) in [(3, 0.4), (-7, 0.0), (0, 2.3), (40, 0.1)] {
            let mut belief = Histogram::new(weights.clone());
            // By hand: the law of one displacement, as many kernels as it takes.
            let mut kernel = vec![0.0; 2 * count + 1];
            kernel[count] = 1.0;
            let times = f64::ceil(variance / 0.5);
            for _ in 0..times as usize {
                let a = 0.5 * variance / times;
                let old = kernel.clone();
                for k in 0..kernel.len() {
                    let at = |k: Option<usize>| k.and_then(|k| old.get(k)).copied().unwrap_or(0.0);
                    kernel[k] =
                        (1.0 - 2.0 * a) * old[k] + a * (at(k.checked_sub(1)) + at(Some(k + 1)));
                }
            }
            let spread: f64 = (0..kernel.len())
                .map(|k| kernel[k] * (k as f64 - count as f64) * (k as f64 - count as f64))
                .sum();
            assert!((spread - variance).abs() < 1e-12, "{spread} for {variance}");
            let before = belief.clone();
            belief.shift(0..count, by);
            belief.spread(0..count, variance);
            let mut expected = vec![0.0; count];
            for (from, mass) in before.cells().iter().enumerate() {
                let moved = (from as i64 + by).clamp(0, count as i64 - 1) as usize;
                for (k, share) in kernel.iter().enumerate() {
                    let to = moved as i64 + k as i64 - count as i64;
                    // Far from the ends only: there the order of the walls counts.
                    if (0..count as i64).contains(&to) {
                        expected[to as usize] += mass * share;
                    }
                }
            }
            let inner = if by == 40 { 6..count - 6 } else { 8..count - 8 };
            for (cell, expected) in expected.iter().enumerate().take(inner.end).skip(inner.start) {
                assert!((belief.cells()[cell] - expected).abs() < 1e-14, "{by} {variance} {cell}");
            }
            assert!((belief.cells().iter().sum::<f64>() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn mass_is_kept_for_ever_and_rows_are_apart() {
        let mut belief = Histogram::new((0..40).map(f64::from).collect());
        let second: f64 = belief.cells()[20..].iter().sum();
        for step in 0..10_000_i64 {
            belief.shift(0..20, step % 5 - 2);
            belief.spread(0..20, 0.01);
            belief.shift(20..40, 2 - step % 5);
            belief.spread(20..40, 1.7);
        }
        assert!((belief.cells().iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert!((belief.cells()[20..].iter().sum::<f64>() - second).abs() < 1e-12);
    }

    #[test]
    fn what_is_impossible_changes_nothing() {
        let mut belief = Histogram::new(vec![1.0, 3.0]);
        assert!(!belief.correct(|_| 0.0) && !belief.correct(|_| f64::NAN));
        assert_eq!(belief.cells(), [0.25, 0.75]);
        assert_eq!(belief.mode(), 1);
        assert_eq!(Histogram::new(vec![0.0; 4]).cells(), [0.25; 4]);
        let mut halves = Histogram::new(vec![1.0, 2.0, 3.0, 4.0]);
        halves.swap_halves();
        assert_eq!(halves.cells(), [0.3, 0.4, 0.1, 0.2]);
        let mut nothing = Histogram::new(Vec::new());
        nothing.shift(0..0, 3);
        nothing.spread(0..0, 1.0);
        assert!(!nothing.correct(|_| 1.0) && nothing.mode() == 0);
    }
}
