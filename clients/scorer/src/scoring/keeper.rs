//! `TraceKeeper`: a run of any length, as a trace of a bounded number of ticks.
//!
//! Up to [`MOST_TICKS`] ticks are all kept. When there are more, every second
//! one goes, and from then on only one of two is kept; again at the next
//! doubling, and so on. So a trace has between half of [`MOST_TICKS`] and all of
//! it, evenly spread over the run, whichever its length, and which ticks those
//! are depends on nothing but the run. Of the ticks of which one is to stay it is
//! the one of which most poses are known, the earliest among equals: a recording
//! with a truth at every hundredth tick keeps its truths. First tick, last tick
//! and that of the last scan are always there.

use rusty_contract::Estimate;
use rusty_contract::log::LogHeader;
use rusty_geometry::{SE2, WorldSpec};

use super::stops::Stops;
use super::trace::{Jump, RunTrace, Whole};

/// The most ticks of a run that are kept to be drawn.
pub const MOST_TICKS: usize = 1 << 17;

/// Keeps what there is to draw of a run.
#[derive(Clone, Debug)]
pub struct TraceKeeper {
    trace: RunTrace,
    /// The tick of each entry of the trace.
    kept: Vec<u64>,
    most: usize,
    /// One of this many ticks is kept.
    stride: u64,
    /// Ticks seen.
    ticks: u64,
    /// The tick seen last, and the last with a scan.
    last: Sample,
    scanned: Sample,
    /// Ranges of the last scan, m.
    ranges_m: Vec<f64>,
    /// Fewer ticks, with all that is known of them.
    stops: Stops,
}

/// One tick of a run.
#[derive(Clone, Debug, Default)]
struct Sample {
    tick: u64,
    time_s: f64,
    truth: Option<SE2>,
    estimates: Vec<Option<SE2>>,
}

impl Sample {
    /// How many poses are known.
    fn known(&self) -> usize {
        usize::from(self.truth.is_some()) + self.estimates.iter().flatten().count()
    }

    fn copy_from(&mut self, other: &Self) {
        (self.tick, self.time_s, self.truth) = (other.tick, other.time_s, other.truth);
        self.estimates.copy_from_slice(&other.estimates);
    }
}

impl TraceKeeper {
    /// A run of which no tick has been seen. Seeing the planned ticks allocates
    /// nothing.
    #[must_use]
    pub fn new(header: &LogHeader) -> Self {
        Self::keeping(MOST_TICKS, RunTrace::new(header), header.config.ticks)
    }

    fn keeping(most: usize, mut trace: RunTrace, planned: u64) -> Self {
        let room = usize::try_from(planned).map_or(most, |n| n.min(most));
        trace.time_s.reserve_exact(room);
        trace.truth.reserve_exact(room);
        trace.estimates.iter_mut().for_each(|series| series.reserve_exact(room));
        let sample = Sample { estimates: vec![None; trace.names.len()], ..Sample::default() };
        Self {
            kept: Vec::with_capacity(room),
            most,
            stride: 1,
            ticks: 0,
            scanned: sample.clone(),
            last: sample,
            ranges_m: Vec::with_capacity(trace.lidar.beams as usize),
            stops: Stops::new(trace.names.len(), trace.lidar.beams as usize, planned),
            trace,
        }
    }

    /// Draws these walls.
    pub fn set_world(&mut self, world: WorldSpec) {
        self.trace.world = world;
    }

    /// Adds a tick, as [`RunTrace::push`] does. Poses that are no numbers count
    /// as not known.
    pub fn push(
        &mut self,
        time_s: f64,
        truth: Option<SE2>,
        scan: Option<&[f64]>,
        estimates: impl Iterator<Item = Option<Estimate>>,
    ) {
        self.stops.push(time_s, truth, scan, estimates);
        let mut estimates = self.stops.last().estimates.iter();
        let last = &mut self.last;
        let (before_s, before) = (last.time_s, last.truth);
        last.tick = self.ticks;
        last.time_s = time_s;
        last.truth = truth.filter(SE2::is_finite);
        if self.trace.kidnapped_at.binary_search(&self.ticks).is_ok() {
            // Before the first tick it is where it starts, at 0 s.
            let before = if self.ticks == 0 { self.trace.start } else { before };
            let jump = before.zip(last.truth).map(|(from, to)| Jump {
                tick: self.ticks,
                time_s: before_s,
                from,
                to,
            });
            self.trace.jumps.extend(jump);
        }
        for place in &mut last.estimates {
            *place = estimates.next().and_then(Option::as_ref).map(|e| e.pose_in_world);
        }
        if let Some(ranges_m) = scan {
            self.scanned.copy_from(last);
            self.ranges_m.clear();
            self.ranges_m.extend_from_slice(ranges_m);
            self.trace.last_scan = Some((0, Vec::new()));
        }
        if self.ticks.is_multiple_of(self.stride) && self.kept.len() == self.most {
            self.halve();
        }
        // After halving, the next tick is again the first of its share.
        if self.ticks.is_multiple_of(self.stride) {
            self.put(self.kept.len());
        } else if self.last.known() > self.known(self.kept.len() - 1) {
            self.put(self.kept.len() - 1);
        }
        self.ticks += 1;
    }

    /// The trace, with the first tick, the last one and that of the last scan in
    /// it; `whole` are the figures of the run.
    #[must_use]
    pub fn finish(mut self, whole: Whole) -> RunTrace {
        if self.ticks > 0 {
            let last = std::mem::take(&mut self.last);
            self.insert(&last);
        }
        if self.trace.last_scan.is_some() {
            let scanned = std::mem::take(&mut self.scanned);
            let at = self.insert(&scanned);
            self.trace.last_scan = Some((at, self.ranges_m));
        }
        self.trace.stops = self.stops.finish();
        count_where_time_stands(&mut self.trace, &self.kept);
        self.trace.thinned_from = (self.stride > 1).then_some(whole);
        self.trace
    }

    /// How many poses are known at an entry.
    fn known(&self, at: usize) -> usize {
        let estimates = self.trace.estimates.iter().filter(|series| series[at].is_some());
        usize::from(self.trace.truth[at].is_some()) + estimates.count()
    }

    /// Writes the last tick to an entry, or to the one after all.
    fn put(&mut self, at: usize) {
        fn set<T>(list: &mut Vec<T>, at: usize, value: T) {
            list.truncate(at);
            list.push(value);
        }
        set(&mut self.kept, at, self.last.tick);
        set(&mut self.trace.time_s, at, self.last.time_s);
        set(&mut self.trace.truth, at, self.last.truth);
        for (series, estimate) in self.trace.estimates.iter_mut().zip(&self.last.estimates) {
            set(series, at, *estimate);
        }
    }

    /// Makes sure that a tick is there, and says where.
    fn insert(&mut self, sample: &Sample) -> usize {
        match self.kept.binary_search(&sample.tick) {
            Ok(at) => at,
            Err(at) => {
                self.kept.insert(at, sample.tick);
                self.trace.time_s.insert(at, sample.time_s);
                self.trace.truth.insert(at, sample.truth);
                for (series, estimate) in self.trace.estimates.iter_mut().zip(&sample.estimates) {
                    series.insert(at, *estimate);
                }
                at
            }
        }
    }

    /// Keeps one of every two entries.
    fn halve(&mut self) {
        let pairs = self.kept.len() / 2;
        for pair in 0..pairs {
            let (first, second) = (2 * pair, 2 * pair + 1);
            // The first tick of all stays, whatever is known of it.
            let better = pair > 0 && self.known(second) > self.known(first);
            let from = if better { second } else { first };
            self.kept[pair] = self.kept[from];
            self.trace.time_s[pair] = self.trace.time_s[from];
            self.trace.truth[pair] = self.trace.truth[from];
            self.trace.estimates.iter_mut().for_each(|series| series[pair] = series[from]);
        }
        self.kept.truncate(pairs);
        self.trace.time_s.truncate(pairs);
        self.trace.truth.truncate(pairs);
        self.trace.estimates.iter_mut().for_each(|series| series.truncate(pairs));
        self.stride *= 2;
    }
}

/// Where the stamps stand still, indices of ticks take their place.
fn count_where_time_stands(trace: &mut RunTrace, kept: &[u64]) {
    let stands = trace.time_s.len() > 1 && trace.time_s.iter().all(|t| *t == trace.time_s[0]);
    trace.is_in_ticks |= stands;
    if trace.is_in_ticks {
        trace.time_s = kept.iter().map(|tick| *tick as f64).collect();
        trace.stops.iter_mut().for_each(|stop| stop.time_s = stop.tick as f64);
    }
}

#[cfg(test)]
mod tests {
    use super::super::trace::tests::empty;
    use super::*;

    const FIGURES: Whole = Whole { ticks: 7, ticks_with_truth: 6, driven_m: 5.0 };

    fn pose(tick: u64) -> Option<SE2> {
        Some(SE2::new(tick as f64, 0.0, 0.0))
    }

    /// A run with a truth at every tick, an estimate at every fifth, and a scan
    /// with it.
    fn run(ticks: u64, mut each: impl FnMut(f64, Option<SE2>, Option<&[f64]>, Option<SE2>)) {
        for tick in 0..ticks {
            let scan = [tick as f64];
            let scan = (tick % 5 == 4).then_some(&scan[..]);
            each(tick as f64 * 0.02, pose(tick), scan, scan.and(pose(tick)));
        }
    }

    fn kept(most: usize, ticks: u64) -> TraceKeeper {
        let mut keeper = TraceKeeper::keeping(most, empty(&["a"]), ticks);
        run(ticks, |t, truth, scan, estimate| {
            keeper.push(t, truth, scan, [estimate.map(Estimate::from)].into_iter());
        });
        keeper
    }

    #[test]
    fn a_run_that_fits_is_kept_as_it_was() {
        for ticks in [0, 1, 4, 5, 63, 64] {
            let mut plain = empty(&["a"]);
            run(ticks, |t, truth, scan, a| plain.push(t, truth, scan, [a].into_iter()));
            let mut trace = kept(64, ticks).finish(FIGURES);
            assert_eq!(std::mem::take(&mut trace.stops).len() as u64, ticks);
            assert_eq!(trace, plain);
        }
    }

    #[test]
    fn a_run_that_does_not_keeps_first_last_and_scan_and_the_ticks_that_tell_most() {
        for ticks in 65..1000u64 {
            let keeper = kept(64, ticks);
            let stride = keeper.stride;
            assert!((33..=64).contains(&keeper.kept.len()), "{ticks}");
            // One of every `stride` ticks, the first with an estimate.
            for (share, &tick) in (0u64..).zip(&keeper.kept) {
                let of = share * stride..((share + 1) * stride).min(ticks);
                let told = of.clone().find(|t| t % 5 == 4).filter(|_| share > 0);
                assert_eq!(tick, told.unwrap_or(of.start), "{ticks}");
            }
            let trace = keeper.finish(FIGURES);
            assert_eq!(trace.thinned_from, Some(FIGURES));
            assert_eq!((trace.truth[0], *trace.truth.last().unwrap()), (pose(0), pose(ticks - 1)));
            let (at, ranges_m) = trace.last_scan.as_ref().unwrap();
            assert_eq!(ranges_m[..], [trace.truth[*at].unwrap().x()]);
            assert_eq!(ranges_m[0] as u64, ticks - 1 - ticks % 5);
            for list in [trace.truth.len(), trace.estimates[0].len()] {
                assert_eq!(list, trace.time_s.len());
            }
            assert!(trace.time_s.is_sorted() && trace.tick_count() <= 66);
        }
    }

    #[test]
    fn where_time_stands_still_the_ticks_are_counted() {
        let mut keeper = TraceKeeper::keeping(4, empty(&[]), 0);
        (0..11).for_each(|tick| keeper.push(1e9, pose(tick), None, std::iter::empty()));
        let trace = keeper.finish(FIGURES);
        assert!(trace.is_in_ticks);
        assert_eq!(trace.time_s, [0.0, 4.0, 8.0, 10.0]);
        assert!(trace.stops.iter().all(|stop| stop.time_s == stop.tick as f64));
        assert!(!kept(64, 2).finish(FIGURES).is_in_ticks);
    }

    #[test]
    fn a_kidnapping_has_the_poses_on_both_sides_whatever_is_thinned() {
        let far = Some(SE2::new(-7.0, 0.0, 0.0));
        for (at, most) in [(0, 64), (1, 4), (37, 4), (37, 64)] {
            let trace = RunTrace { kidnapped_at: vec![at, 900], start: far, ..empty(&[]) };
            let mut keeper = TraceKeeper::keeping(most, trace, 0);
            for tick in 0..100 {
                keeper.push(0.5 * (tick + 1) as f64, pose(tick), None, std::iter::empty());
            }
            let from = at.checked_sub(1).map_or(far, pose);
            let expected = Jump {
                tick: at,
                time_s: 0.5 * at as f64,
                from: from.unwrap(),
                to: pose(at).unwrap(),
            };
            assert_eq!(keeper.finish(FIGURES).jumps, [expected]);
        }
    }

    #[test]
    fn a_million_ticks_take_the_room_of_the_first_ones() {
        let keeper = kept(MOST_TICKS, 1_000_000);
        assert_eq!(keeper.stride, 8);
        for room in [
            keeper.kept.capacity(),
            keeper.trace.time_s.capacity(),
            keeper.trace.truth.capacity(),
            keeper.trace.estimates[0].capacity(),
        ] {
            assert_eq!(room, MOST_TICKS);
        }
        assert!(keeper.ranges_m.capacity() <= 1080);
    }
}
