//! `Stops`: a bounded number of ticks of a run with all that is known of them,
//! covariances and scans included, for a reader who looks at one tick after
//! the other.
//!
//! Where there are more ticks than room, one of every two goes, as
//! [`super::keeper`] does it: what is left is spread evenly over the run, and of
//! the ticks of which one is to stay it is the one of which most is known, with
//! a scan if there is one. All room is taken at the start.

use rusty_contract::Estimate;
use rusty_geometry::SE2;

/// The most stops that are kept; it is even.
pub const MOST_STOPS: usize = 1536;
/// With many estimators there are fewer stops: this many estimates in all.
const MOST_ESTIMATES: usize = 14_336;

/// One tick. Poses are in the world frame and made of numbers.
#[derive(Debug, Default, PartialEq)]
pub struct Stop {
    /// The tick.
    pub tick: u64,
    /// Its time, s.
    pub time_s: f64,
    /// True pose of the body, where known.
    pub truth: Option<SE2>,
    /// What is in effect of what the estimators said, in roster order.
    pub estimates: Vec<Option<Estimate>>,
    /// Whether it has a scan.
    pub has_scan: bool,
    /// The ranges of its scan, m, beam by beam.
    pub ranges_m: Vec<f32>,
}

/// What is kept of a run.
#[derive(Clone, Debug)]
pub struct Stops {
    kept: Vec<Stop>,
    /// How many of them count; the rest is room.
    count: usize,
    most: usize,
    /// One of this many ticks is kept.
    stride: u64,
    ticks: u64,
    /// The tick seen last, and the last with a scan.
    last: Stop,
    scanned: Stop,
}

impl Clone for Stop {
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.clone_from(self);
        copy
    }

    /// Takes no memory where there is room enough.
    fn clone_from(&mut self, other: &Self) {
        (self.tick, self.time_s, self.truth) = (other.tick, other.time_s, other.truth);
        self.estimates.clone_from(&other.estimates);
        self.has_scan = other.has_scan;
        self.ranges_m.clone_from(&other.ranges_m);
    }
}

impl Stop {
    /// How much is known: a pose counts more than a scan.
    fn known(&self) -> usize {
        let poses = usize::from(self.truth.is_some()) + self.estimates.iter().flatten().count();
        2 * poses + usize::from(self.has_scan)
    }

    /// What an estimator (index of its name) says at this tick.
    #[must_use]
    pub fn estimate(&self, estimator: usize) -> Option<&Estimate> {
        self.estimates.get(estimator)?.as_ref()
    }
}

impl Stops {
    /// A run of which no tick has been seen: N estimators, beams and
    /// ticks to come. Seeing those allocates nothing.
    #[must_use]
    pub fn new(estimators: usize, beams: usize, planned: u64) -> Self {
        let most = (MOST_ESTIMATES / estimators.max(1)).min(MOST_STOPS);
        Self::keeping(most & !1, estimators, beams, planned)
    }

    fn keeping(most: usize, estimators: usize, beams: usize, planned: u64) -> Self {
        let room = usize::try_from(planned).map_or(most, |n| n.min(most));
        // Lists of full length, so that copies have the room, too.
        let stop = Stop {
            estimates: vec![None; estimators],
            ranges_m: vec![0.0; beams],
            ..Stop::default()
        };
        let (kept, scanned) = (vec![stop.clone(); room], stop.clone());
        Self { kept, count: 0, most, stride: 1, ticks: 0, last: stop, scanned }
    }

    /// Adds a tick. Estimates come in roster order; those that are missing at
    /// the end count as not given. Poses that are no numbers count as not known.
    pub fn push(
        &mut self,
        time_s: f64,
        truth: Option<SE2>,
        scan: Option<&[f64]>,
        mut estimates: impl Iterator<Item = Option<Estimate>>,
    ) {
        let last = &mut self.last;
        (last.tick, last.time_s) = (self.ticks, time_s);
        last.truth = truth.filter(SE2::is_finite);
        for place in &mut last.estimates {
            *place = estimates.next().flatten().filter(|e| e.pose_in_world.is_finite());
        }
        last.has_scan = scan.is_some();
        last.ranges_m.clear();
        if let Some(ranges_m) = scan {
            last.ranges_m.extend(ranges_m.iter().map(|&r| r as f32));
            self.scanned.clone_from(&self.last);
        }
        if self.ticks.is_multiple_of(self.stride) {
            if self.count == self.most {
                self.halve();
            }
            // After halving, the next tick is again the first of its share.
            if self.ticks.is_multiple_of(self.stride) {
                self.put(self.count);
            }
        } else if self.last.known() > self.kept[self.count - 1].known() {
            self.put(self.count - 1);
        }
        self.ticks += 1;
    }

    /// The tick seen last.
    pub(super) fn last(&self) -> &Stop {
        &self.last
    }

    /// Copies the last tick to a place, or to the one after all.
    fn put(&mut self, at: usize) {
        match self.kept.get_mut(at) {
            Some(place) => place.clone_from(&self.last),
            None => self.kept.push(self.last.clone()),
        }
        self.count = self.count.max(at + 1);
    }

    /// Keeps one of every two stops.
    fn halve(&mut self) {
        for pair in 0..self.count / 2 {
            let (first, second) = (2 * pair, 2 * pair + 1);
            // The first tick of all stays, whatever is known of it.
            let better = pair > 0 && self.kept[second].known() > self.kept[first].known();
            self.kept.swap(pair, if better { second } else { first });
        }
        self.count /= 2;
        self.stride *= 2;
    }

    /// The stops in order, the first tick, the last one and that of the last
    /// scan among them.
    #[must_use]
    pub fn finish(mut self) -> Vec<Stop> {
        self.kept.truncate(self.count);
        if self.ticks > 0 {
            for stop in [self.scanned, self.last] {
                let is_one = stop.has_scan || stop.tick + 1 == self.ticks;
                match self.kept.binary_search_by_key(&stop.tick, |kept| kept.tick) {
                    Err(at) if is_one => self.kept.insert(at, stop),
                    _ => {}
                }
            }
        }
        self.kept
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn estimate(tick: u64) -> Option<Estimate> {
        let pose = SE2::new(tick as f64, 0.0, 0.0);
        Some(Estimate { covariance: Some([tick as f64; 9]), ..Estimate::from(pose) })
    }

    /// A run with an estimate at every tick, and a scan at every fifth.
    fn stops(most: usize, ticks: u64, planned: u64) -> Stops {
        let mut stops = Stops::keeping(most, 1, 2, planned);
        for tick in 0..ticks {
            let scan = [tick as f64, 1.0];
            let scan = (tick % 5 == 4).then_some(&scan[..]);
            let truth = Some(SE2::new(0.0, tick as f64, 0.0));
            stops.push(tick as f64 * 0.02, truth, scan, [estimate(tick)].into_iter());
        }
        stops
    }

    #[test]
    fn a_run_that_fits_is_kept_tick_by_tick() {
        for (ticks, planned) in [(0, 9), (1, 1), (63, 64), (64, 10)] {
            let kept = stops(64, ticks, planned).finish();
            assert_eq!(kept.len() as u64, ticks);
            for (tick, stop) in (0..ticks).zip(&kept) {
                assert_eq!((stop.tick, stop.time_s), (tick, tick as f64 * 0.02));
                assert_eq!(stop.estimates, [estimate(tick)]);
                assert_eq!(stop.truth.map(|t| t.y()), Some(tick as f64));
                assert_eq!(stop.has_scan, tick % 5 == 4);
                let ranges_m: &[f32] = if stop.has_scan { &[tick as f32, 1.0] } else { &[] };
                assert_eq!(stop.ranges_m, ranges_m);
            }
        }
    }

    #[test]
    fn of_a_longer_one_first_last_and_scans_stay_evenly_spread() {
        for ticks in 65..1000u64 {
            let stops = stops(64, ticks, ticks);
            let (stride, count) = (stops.stride, stops.count);
            assert!((33..=64).contains(&count), "{ticks}");
            let kept = stops.finish();
            let at: Vec<u64> = kept.iter().map(|stop| stop.tick).collect();
            assert!(at.is_sorted_by(|a, b| a < b), "{at:?}");
            assert!((at[0], at[at.len() - 1]) == (0, ticks - 1), "{at:?}");
            assert!(at.contains(&(ticks - 1 - ticks % 5)), "{at:?}");
            assert!(at.windows(2).all(|pair| pair[1] - pair[0] < 2 * stride), "{at:?}");
            // From a stride of eight on, every share has a scan to offer.
            let scans = kept.iter().filter(|stop| stop.has_scan).count();
            assert!(stride < 8 || scans + 3 >= kept.len(), "{scans} of {}", kept.len());
        }
    }

    #[test]
    fn poses_that_are_no_numbers_are_none() {
        let mut stops = Stops::new(2, 0, 1);
        let broken = SE2::new(f64::NAN, 0.0, 0.0);
        stops.push(0.0, Some(broken), None, [Some(broken.into())].into_iter());
        assert_eq!(stops.finish()[0], Stop { estimates: vec![None; 2], ..Stop::default() });
    }
}
