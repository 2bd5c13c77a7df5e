//! `Quantiles`: any percentile of numbers that come one by one, in memory that
//! does not grow with them.
//!
//! Up to [`MOST_KEPT`] numbers (or fewer, where that was asked for) are kept and
//! sorted: percentiles are exact. More
//! of them are counted in bins instead, 4096 to every power of two: then a
//! percentile is off by less than 1/4096 of itself (0.025 %), or by 10⁻⁹ where
//! it is smaller than that; numbers beyond 10¹² count as that.
//!
//! Idea: G. Tene, *HdrHistogram*. Departure: bins are the upper bits of an
//! IEEE 754 number, whose bits are ordered as the numbers are, so that nothing is
//! computed to find one.

/// Up to this many numbers percentiles are exact.
pub const MOST_KEPT: usize = 1 << 20;

/// Bits of the mantissa that stay: 2¹² bins to every power of two.
const BITS: u32 = 12;
const SHIFT: u32 = f64::MANTISSA_DIGITS - 1 - BITS;
/// Smaller numbers, and larger ones, share a bin (2⁻³⁰ and 2⁴⁰).
const LEAST: f64 = 1.0 / (1u64 << 30) as f64;
const GREATEST: f64 = (1u64 << 40) as f64;
const FIRST: u64 = LEAST.to_bits() >> SHIFT;
const BINS: usize = ((GREATEST.to_bits() >> SHIFT) - FIRST) as usize + 2;

/// The value at `fraction` (0 to 1) of the way through the sorted values, linear
/// between ranks: the definition of numpy's default, of the scorer, and of the
/// tables of the chapter. `None` where there are no values. Changes their order.
#[must_use]
pub fn percentile(values: &mut [f64], fraction: f64) -> Option<f64> {
    let rank = fraction.clamp(0.0, 1.0) * values.len().checked_sub(1)? as f64;
    let below = rank.floor();
    let (_, low, rest) = values.select_nth_unstable_by(below as usize, f64::total_cmp);
    let low = *low;
    let high = match rest.iter().copied().min_by(f64::total_cmp) {
        Some(next) if rank > below => next,
        _ => low,
    };
    Some(low + (high - low) * (rank - below))
}

/// Numbers that are not negative, seen one by one.
#[derive(Clone, Debug)]
pub struct Quantiles {
    kept: Vec<f64>,
    most_kept: usize,
    /// Empty as long as all numbers are kept.
    bins: Vec<u64>,
    count: u64,
    least: f64,
    greatest: f64,
}

impl Quantiles {
    /// None seen yet, with room for as many as are expected, so that seeing
    /// them allocates nothing.
    #[must_use]
    pub fn expecting(count: u64) -> Self {
        Self::keeping(MOST_KEPT, count)
    }

    /// The same, but keeping no more than `most_kept`, 8 bytes each, before it
    /// goes over to bins.
    #[must_use]
    pub fn keeping(most_kept: usize, expected: u64) -> Self {
        let room = usize::try_from(expected).map_or(most_kept, |n| n.min(most_kept));
        let kept = Vec::with_capacity(room);
        let (least, greatest) = (f64::INFINITY, f64::NEG_INFINITY);
        Self { kept, most_kept, bins: Vec::new(), count: 0, least, greatest }
    }

    /// Adds a number; what is no number, or negative, counts as 0.
    pub fn push(&mut self, value: f64) {
        let value = if value > 0.0 { value } else { 0.0 };
        self.count += 1;
        self.least = self.least.min(value);
        self.greatest = self.greatest.max(value);
        if !self.bins.is_empty() {
            self.bins[bin(value)] += 1;
        } else if self.kept.len() < self.most_kept {
            self.kept.push(value);
        } else {
            self.bins = vec![0; BINS];
            for value in std::mem::take(&mut self.kept).into_iter().chain([value]) {
                self.bins[bin(value)] += 1;
            }
        }
    }

    /// Forgets all of them, but not the room they need.
    pub fn clear(&mut self) {
        let mut kept = std::mem::take(&mut self.kept);
        kept.clear();
        *self = Self { kept, ..Self::keeping(self.most_kept, 0) };
    }

    /// How many there were.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.count
    }

    /// The value at `fraction` (0 to 1) of the way through the sorted numbers,
    /// linear between ranks (numpy's default). `None` if there are none. Changes
    /// the order of what is kept.
    pub fn at(&mut self, fraction: f64) -> Option<f64> {
        if self.bins.is_empty() {
            return percentile(&mut self.kept, fraction);
        }
        let rank = fraction * self.count.checked_sub(1)? as f64;
        let (low, high) = (self.ranked(rank.floor() as u64), self.ranked(rank.ceil() as u64));
        Some(low + (high - low) * (rank - rank.floor()))
    }

    /// Of what is in bins the number that this many others come before.
    fn ranked(&self, rank: u64) -> f64 {
        if rank == 0 {
            return self.least;
        }
        let mut before = 0;
        for (i, &count) in self.bins.iter().enumerate() {
            if rank < before + count {
                let (from, to) = (edge(i), edge(i + 1));
                let within = ((rank - before) as f64 + 0.5) / count as f64;
                return (from + (to - from) * within).clamp(self.least, self.greatest);
            }
            before += count;
        }
        self.greatest
    }
}

fn bin(value: f64) -> usize {
    if value < LEAST {
        return 0;
    }
    ((value.to_bits() >> SHIFT) - FIRST + 1).min(BINS as u64 - 1) as usize
}

/// Where a bin begins.
fn edge(bin: usize) -> f64 {
    match bin.checked_sub(1) {
        None => 0.0,
        Some(i) => f64::from_bits((FIRST + i as u64) << SHIFT),
    }
}

impl Default for Quantiles {
    fn default() -> Self {
        Self::expecting(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Drifts as a run has them: from nothing to metres, in no order.
    fn drift_m(k: u64) -> f64 {
        let k = k.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 40;
        k as f64 * k as f64 * 1e-14
    }

    #[test]
    fn percentiles_are_linear_between_ranks() {
        // numpy.percentile([1, 2, 3, 4], [0, 50, 95, 100]) = [1, 2.5, 3.85, 4]
        let mut four = Quantiles::expecting(4);
        [4.0, 1.0, 3.0, 2.0].into_iter().for_each(|v| four.push(v));
        for (fraction, value) in [(0.0, 1.0), (0.5, 2.5), (0.95, 3.85), (1.0, 4.0)] {
            assert!((four.at(fraction).unwrap() - value).abs() < 1e-12);
        }
        assert_eq!(Quantiles::expecting(9).at(0.5), None);
    }

    #[test]
    fn a_percentile_is_that_of_the_sorted_values() {
        let mut some = Quantiles::expecting(0);
        for count in 1..120_u64 {
            some.clear();
            let mut sorted: Vec<f64> = (0..count).map(drift_m).collect();
            sorted.iter().for_each(|value| some.push(*value));
            sorted.sort_by(f64::total_cmp);
            let rank = 0.95 * (count - 1) as f64;
            let (low, high) = (sorted[rank.floor() as usize], sorted[rank.ceil() as usize]);
            let expected = low + (high - low) * (rank - rank.floor());
            assert_eq!(some.at(0.95), Some(expected), "{count} values");
        }
    }

    #[test]
    fn bins_are_as_good_as_they_say_and_take_no_more_room() {
        let (mut all, mut few) =
            (Quantiles::keeping(300_000, 0), Quantiles::keeping(1000, 1 << 40));
        assert_eq!(few.kept.capacity(), 1000);
        for k in 0..300_000 {
            all.push(drift_m(k));
            few.push(drift_m(k));
        }
        assert!(all.bins.is_empty() && few.kept.capacity() == 0 && few.bins.len() == BINS);
        assert_eq!((all.count(), few.count()), (300_000, 300_000));
        for fraction in [0.0, 0.001, 0.05, 0.25, 0.5, 0.9, 0.95, 0.999, 1.0] {
            let (exact, near) = (all.at(fraction).unwrap(), few.at(fraction).unwrap());
            assert!((near - exact).abs() <= exact / 4096.0 + 1e-9, "{fraction}: {near}, {exact}");
        }
    }

    #[test]
    fn every_number_has_a_bin_around_it() {
        const { assert!(BINS * 8 < 3 << 20) };
        for value in [0.0, 1e-300, 1e-10, LEAST, 0.1, 1.0, 1.5, 2.0, 1e6, GREATEST] {
            let i = bin(value);
            assert!(edge(i) <= value && value < edge(i + 1), "{value}");
            assert!(i < 2 || edge(i + 1) - edge(i) <= value / 4096.0, "{value}");
        }
        for odd in [f64::INFINITY, 1e300, f64::MAX] {
            assert_eq!(bin(odd), BINS - 1);
        }
        let mut odd = Quantiles::keeping(1, 0);
        [f64::NAN, -1.0, f64::INFINITY, 1e300].into_iter().for_each(|v| odd.push(v));
        assert_eq!(odd.at(0.0), Some(0.0));
        assert!(odd.at(1.0).unwrap() >= GREATEST);
    }
}
