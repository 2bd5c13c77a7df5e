//! The Allan deviation of a rate, from a stream.
//!
//! Source: D. W. Allan, *Statistics of Atomic Frequency Standards* (1966); IEEE Std
//! 952-1997, annex C. With the means ȳ of neighbouring intervals of length τ,
//! σ²(τ) = ½·E[(ȳ₂ − ȳ₁)²].
//!
//! Departures: intervals do not overlap and have the lengths 2^k·dt, so that memory is
//! that of a few numbers for each k, however long the stream is.

/// Fewest differences that an estimate is made of.
const FEWEST: u64 = 4;

/// Octaves at most, so that no value allocates: 2^47 values.
const MOST_OCTAVES: usize = 48;

/// A stream of equally spaced values.
#[derive(Clone, Debug, PartialEq)]
pub struct Allan {
    dt_s: f64,
    octaves: Vec<Octave>,
}

/// The means over 2^k values.
#[derive(Clone, Debug, Default, PartialEq)]
struct Octave {
    /// The mean before.
    last: Option<f64>,
    /// The first of two that become one of the next octave.
    first: Option<f64>,
    sum_of_squares: f64,
    differences: u64,
}

/// The Allan deviation at one length of interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AllanDeviation {
    /// τ, s.
    pub interval_s: f64,
    /// σ(τ), in the unit of the values.
    pub deviation: f64,
    /// Differences that it is made of. Its relative standard error is about
    /// 1/√(2·`differences`), times 1.2 for white noise.
    pub differences: u64,
}

impl Allan {
    /// No value yet; one comes every `dt_s` seconds.
    #[must_use]
    pub fn new(dt_s: f64) -> Self {
        Self { dt_s, octaves: Vec::with_capacity(MOST_OCTAVES) }
    }

    /// Adds the next value: the mean over `dt_s`.
    pub fn push(&mut self, value: f64) {
        let mut mean = value;
        for k in 0..MOST_OCTAVES {
            if k == self.octaves.len() {
                self.octaves.push(Octave::default());
            }
            let octave = &mut self.octaves[k];
            if let Some(last) = octave.last.replace(mean) {
                octave.sum_of_squares += (mean - last) * (mean - last);
                octave.differences += 1;
            }
            match octave.first.take() {
                Some(first) => mean = 0.5 * (first + mean),
                None => {
                    octave.first = Some(mean);
                    return;
                }
            }
        }
    }

    /// σ at every length of interval of which there are enough, shortest first.
    pub fn deviations(&self) -> impl Iterator<Item = AllanDeviation> {
        let lengths = std::iter::successors(Some(self.dt_s), |length_s| Some(2.0 * length_s));
        let known = lengths.zip(&self.octaves).filter(|(_, o)| o.differences >= FEWEST);
        known.map(|(interval_s, octave)| AllanDeviation {
            interval_s,
            deviation: (0.5 * octave.sum_of_squares / octave.differences as f64).sqrt(),
            differences: octave.differences,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_alternating_value_averages_out_and_a_constant_has_no_deviation() {
        let (mut alternating, mut constant) = (Allan::new(0.5), Allan::new(0.5));
        for k in 0..64 {
            alternating.push(if k % 2 == 0 { 1.0 } else { -1.0 });
            constant.push(7.0);
        }
        let found: Vec<_> = alternating.deviations().collect();
        // Neighbours differ by 2 in all of 63 pairs; the mean of two is 0.
        let first = AllanDeviation { interval_s: 0.5, deviation: 2f64.sqrt(), differences: 63 };
        assert_eq!(found[0], first);
        assert!(found[1..].iter().all(|d| d.deviation == 0.0));
        assert!(constant.deviations().all(|d| d.deviation == 0.0));
    }

    #[test]
    fn a_ramp_grows_with_the_interval() {
        // Means of neighbouring intervals of a ramp a·t differ by a·τ: σ = a·τ/√2.
        let mut allan = Allan::new(0.01);
        (0..4096).for_each(|k| allan.push(3.0 * 0.01 * f64::from(k)));
        let found: Vec<_> = allan.deviations().collect();
        // 2^10 intervals of 4 values, …, 4 of 1024: 3 differences are too few.
        assert_eq!(found.len(), 10);
        assert_eq!(found[3].differences, 511);
        for AllanDeviation { interval_s, deviation, .. } in found {
            assert!((deviation - 3.0 * interval_s / 2f64.sqrt()).abs() < 1e-9 * interval_s);
        }
        assert!(Allan::new(0.01).deviations().next().is_none());
    }
}
