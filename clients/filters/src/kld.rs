//! How many particles a belief needs, and which of them belong together.
//!
//! Source: D. Fox, *Adapting the Sample Size in Particle Filters Through
//! KLD-Sampling* (International Journal of Robotics Research 22(12), 2003), and
//! *Probabilistic Robotics*, §8.3.7, Table 8.4: with
//! n = (k − 1)/2ε · (1 − 2/9(k−1) + √(2/9(k−1)) z)³ particles, the divergence
//! between the belief and its histogram of k occupied bins is below ε with
//! the probability of which z is the quantile (a χ² law by Wilson and Hilferty).
//!
//! Bins that touch, at a corner too, are one *mode* of the belief.

use core::f64::consts::TAU;

use rusty_geometry::SE2;

/// How many particles for `bins` occupied bins, an error of `epsilon`, and the
/// quantile `z` of the normal law.
pub fn sample_size(bins: usize, epsilon: f64, z: f64) -> usize {
    if bins < 2 {
        return 1;
    }
    let degrees = (bins - 1) as f64;
    let a = 2.0 / (9.0 * degrees);
    let b = 1.0 - a + a.sqrt() * z;
    (degrees / (2.0 * epsilon) * (b * b * b)).ceil() as usize
}

/// Number of a bin. Bins next to each other in y are next to each other here.
type Key = u64;

/// Bits for each of the three numbers in a key.
const BITS: u32 = 21;
const MIDDLE: i64 = 1 << (BITS - 1);

/// Poses put into bins, and bins put together.
#[derive(Clone, Debug)]
pub struct Bins {
    side_m: f64,
    turns: i64,
    /// Bin and number of each pose, by bin.
    sorted: Vec<(Key, u32)>,
    /// The occupied bins, in order, and which of them each is one with.
    keys: Vec<Key>,
    parent: Vec<u32>,
    /// The mode of each pose.
    mode_of: Vec<u32>,
}

impl Bins {
    /// Bins with sides of `side_m`, `turns` of them to a full turn.
    pub fn new(side_m: f64, turns: u32) -> Self {
        let turns = i64::from(turns.max(1));
        Self {
            side_m,
            turns,
            sorted: Vec::new(),
            keys: Vec::new(),
            parent: Vec::new(),
            mode_of: Vec::new(),
        }
    }

    fn key(&self, pose: &SE2) -> Key {
        // The cast saturates, and what is no number is in the middle.
        let along = |v: f64| ((v / self.side_m).floor() as i64).clamp(1 - MIDDLE, MIDDLE - 2);
        let turn = (pose.theta() / TAU * self.turns as f64).floor() as i64;
        join(turn.rem_euclid(self.turns), along(pose.x()), along(pose.y()))
    }

    /// Puts poses into bins, and says how many bins there are.
    pub fn fill(&mut self, poses: impl Iterator<Item = SE2>) -> usize {
        self.sorted.clear();
        for (number, pose) in poses.enumerate() {
            let key = self.key(&pose);
            self.sorted.push((key, number as u32));
        }
        self.sorted.sort_unstable();
        self.keys.clear();
        self.keys.extend(self.sorted.iter().map(|(key, _)| key));
        self.keys.dedup();
        self.keys.len()
    }

    /// The mode of every pose that [`fill`](Self::fill) was given: poses of one
    /// mode have the same number.
    pub fn modes(&mut self) -> &[u32] {
        self.parent.clear();
        self.parent.extend(0..self.keys.len() as u32);
        // Half of the 26 neighbours: the others have this one for theirs.
        for turn in [0, 1] {
            for x in [-1, 0, 1] {
                for y in [-1, 0, 1] {
                    if (turn, x, y) > (0, 0, 0) {
                        self.unite(turn, x, y);
                    }
                }
            }
        }
        self.mode_of.clear();
        self.mode_of.resize(self.sorted.len(), 0);
        let mut bin = 0;
        for &(key, number) in &self.sorted {
            bin += u32::from(self.keys[bin as usize] != key);
            let root = root(&mut self.parent, bin);
            self.mode_of[number as usize] = root;
        }
        &self.mode_of
    }

    /// Makes each bin one with that which lies so far from it, if it is there.
    fn unite(&mut self, turn: i64, x: i64, y: i64) {
        let mut there = 0;
        for here in 0..self.keys.len() {
            let (t, u, v) = split(self.keys[here]);
            let wanted = join((t + turn) % self.turns, u + x, v + y);
            // The wanted ones come in order, but for where the turn is full.
            if there >= self.keys.len() || self.keys[there] > wanted {
                there = self.keys.partition_point(|key| *key < wanted);
            }
            while there < self.keys.len() && self.keys[there] < wanted {
                there += 1;
            }
            if self.keys.get(there) == Some(&wanted) {
                let (a, b) =
                    (root(&mut self.parent, here as u32), root(&mut self.parent, there as u32));
                self.parent[a.max(b) as usize] = a.min(b);
            }
        }
    }
}

/// The first of the bins that `bin` is one with.
fn root(parent: &mut [u32], mut bin: u32) -> u32 {
    while parent[bin as usize] != bin {
        parent[bin as usize] = parent[parent[bin as usize] as usize];
        bin = parent[bin as usize];
    }
    bin
}

fn join(turn: i64, x: i64, y: i64) -> Key {
    ((turn as u64) << (2 * BITS)) | (((x + MIDDLE) as u64) << BITS) | (y + MIDDLE) as u64
}

fn split(key: Key) -> (i64, i64, i64) {
    let mask = (1 << BITS) - 1;
    let part = |shift: u32| ((key >> shift) & mask) as i64;
    (part(2 * BITS), part(BITS) - MIDDLE, part(0) - MIDDLE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rusty_metrics::chi_square;

    #[test]
    fn sizes_are_those_of_the_chi_square_law() {
        // n = χ²(k−1, 1−δ) / 2ε, of which the formula is the usual approximation.
        for k in [2, 3, 10, 100, 2000] {
            for (level, z) in [(0.99, 2.326_347_874), (0.95, 1.644_853_627)] {
                let exact = chi_square::quantile(level, (k - 1) as f64) / (2.0 * 0.05);
                let said = sample_size(k, 0.05, z) as f64;
                let slack = if k < 4 { 0.03 } else { 0.005 };
                assert!((said - exact).abs() <= slack * exact + 1.0, "{k}: {said} for {exact}");
            }
        }
        assert_eq!((sample_size(0, 0.05, 2.3), sample_size(1, 0.05, 2.3)), (1, 1));
    }

    fn modes(poses: &[SE2]) -> Vec<u32> {
        let mut bins = Bins::new(0.5, 36);
        bins.fill(poses.iter().copied());
        bins.modes().to_vec()
    }

    #[test]
    fn bins_are_counted_once() {
        let mut bins = Bins::new(0.1, 36);
        let pose = |x_m, y_m, theta_rad| SE2::new(x_m, y_m, theta_rad);
        let poses = [
            pose(0.05, 0.05, 0.0),
            pose(0.08, 0.01, 0.1),
            pose(-0.05, 0.05, 0.0),
            pose(0.05, 0.05, -0.1),
            pose(0.05, 0.05, 3.1),
            pose(0.05, 0.05, -3.1),
        ];
        assert_eq!(bins.fill(poses.into_iter()), 5);
        assert_eq!(bins.fill(std::iter::empty()), 0);
        assert!(bins.modes().is_empty());
        let nowhere = [pose(f64::NAN, f64::INFINITY, 0.0), pose(-1e300, 1e300, f64::NAN)];
        assert!(bins.fill(nowhere.into_iter()) <= 2);
        assert_eq!(bins.modes().len(), 2);
    }

    #[test]
    fn what_touches_is_one_mode_and_what_does_not_is_not() {
        let pose = |x_m, y_m, theta_rad| SE2::new(x_m, y_m, theta_rad);
        // A chain over a corner and over the full turn; one apart; one turned away.
        let found = modes(&[
            pose(0.2, 0.2, 3.1),
            pose(0.7, 0.7, 3.1),
            pose(1.2, 0.7, -3.1),
            pose(2.2, 0.7, -3.1),
            pose(0.2, 0.2, 1.0),
            pose(-0.2, 0.2, 3.1),
        ]);
        assert_eq!(found[0], found[1]);
        assert_eq!(found[0], found[2]);
        assert_eq!(found[0], found[5]);
        assert!(found[3] != found[0] && found[4] != found[0] && found[3] != found[4], "{found:?}");
    }

    #[test]
    fn modes_are_those_of_asking_every_pair() {
        let mut random = crate::Random::new(4, 1);
        let poses: Vec<SE2> = (0..400)
            .map(|_| {
                let mut along = || 12.0 * random.uniform() - 6.0;
                SE2::new(along(), along(), along())
            })
            .collect();
        let found = modes(&poses);
        let bins = Bins::new(0.5, 36);
        let keys: Vec<_> = poses.iter().map(|p| split(bins.key(p))).collect();
        // Spread what is known until nothing changes.
        let mut slow: Vec<usize> = (0..poses.len()).collect();
        loop {
            let before = slow.clone();
            for (i, a) in keys.iter().enumerate() {
                for (j, b) in keys.iter().enumerate() {
                    let turn = (a.0 - b.0).rem_euclid(36);
                    let near = |d: i64| d.abs() <= 1;
                    if near(a.1 - b.1) && near(a.2 - b.2) && [0, 1, 35].contains(&turn) {
                        slow[i] = slow[i].min(slow[j]);
                    }
                }
            }
            if slow == before {
                break;
            }
        }
        for i in 0..poses.len() {
            for j in 0..poses.len() {
                assert_eq!(found[i] == found[j], slow[i] == slow[j], "{i}, {j}");
            }
        }
    }
}
