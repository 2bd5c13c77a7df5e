//! A run as it is drawn: truth and estimates, tick by tick.

use rusty_contract::config::LidarConfig;
use rusty_contract::log::{Finding, LogHeader};
use rusty_contract::score::{PriorKnowledge, ReferenceNoise, Score, ScoreReport};
use rusty_geometry::{SE2, WorldSpec};
use rusty_metrics::PathLength;

use super::beliefs::BeliefTrack;
use super::sensed::Sensed;
use super::stops::Stop;

/// A run, as far as it has been seen. All poses are in the world frame.
///
/// `time_s`, `truth` and each of `estimates` have one entry per tick;
/// `estimates` has one list per name. [`RunTrace::push`] keeps it so.
#[derive(Clone, Debug, PartialEq)]
pub struct RunTrace {
    /// Name of the scenario.
    pub scenario: String,
    /// The seed, where the run was simulated.
    pub seed: Option<u64>,
    /// Run digest, 32 hexadecimal digits; empty while it is not known.
    pub digest: String,
    /// The walls; there may be none.
    pub world: WorldSpec,
    /// Where the beams of a scan point.
    pub lidar: LidarConfig,
    /// Names of the answering participants, in roster order.
    pub names: Vec<String>,
    /// Time of each tick, s; its index where `is_in_ticks`.
    pub time_s: Vec<f64>,
    /// Whether times here are indices of ticks: the stamps of the recording stand still.
    pub is_in_ticks: bool,
    /// True pose of the body at each tick, where known.
    pub truth: Vec<Option<SE2>>,
    /// Believed pose of the body: outer index as `names`, inner index the tick.
    pub estimates: Vec<Vec<Option<SE2>>>,
    /// What each of them was told.
    pub told: Vec<PriorKnowledge>,
    /// The true pose before the first tick, where known.
    pub start: Option<SE2>,
    /// The true poses' own errors, for NEES.
    pub reference: ReferenceNoise,
    /// The ticks at whose start the robot was put elsewhere.
    pub kidnapped_at: Vec<u64>,
    /// The kidnappings that a [`TraceKeeper`](super::TraceKeeper) saw.
    pub jumps: Vec<Jump>,
    /// The last scan: index of its tick, and its ranges in m, beam by beam.
    pub last_scan: Option<(usize, Vec<f64>)>,
    /// Where the ticks here are some of a longer run: what the whole of it was.
    pub thinned_from: Option<Whole>,
    /// Some of the ticks, with covariances and scans ([`super::stops`]); none
    /// unless a [`TraceKeeper`](super::TraceKeeper) put them here.
    pub stops: Vec<Stop>,
    /// What filters showed of what they held possible, as far as it came
    /// ([`super::beliefs`]); most runs have none.
    pub beliefs: Vec<BeliefTrack>,
    /// What the small sensors read; most runs have none.
    pub sensed: Option<Sensed>,
    /// Whether it was read from a log, which does not hold everything.
    pub from_log: bool,
    /// When and how the run was started, where that is known.
    pub origin: Option<Origin>,
}

/// When a run was started, and by which command.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Origin {
    /// Date and time, UTC.
    pub started_utc: String,
    /// Command line; may be empty.
    pub command: String,
}

/// A kidnapping: the true poses before and after it, world frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jump {
    /// Index of the tick at whose start it happened.
    pub tick: u64,
    /// Time at the start of that tick, s.
    pub time_s: f64,
    /// Pose before it.
    pub from: SE2,
    /// Pose at the end of the tick.
    pub to: SE2,
}

/// A run in figures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Whole {
    /// Ticks.
    pub ticks: u64,
    /// Ticks with a true pose that can be compared with.
    pub ticks_with_truth: u64,
    /// Distance truly driven, m.
    pub driven_m: f64,
}

impl RunTrace {
    /// A run of which no tick has been seen. The digest is known only at the
    /// end; set it then.
    #[must_use]
    pub fn new(header: &LogHeader) -> Self {
        let names: Vec<String> = header.answering().map(|p| p.name.clone()).collect();
        Self {
            scenario: header.config.scenario.clone(),
            seed: header.seed(),
            digest: String::new(),
            world: header.config.world.clone(),
            lidar: header.config.lidar,
            time_s: Vec::new(),
            is_in_ticks: header.findings().iter().any(|f| matches!(f, Finding::FlatStamps { .. })),
            truth: Vec::new(),
            estimates: vec![Vec::new(); names.len()],
            told: header.answering().map(PriorKnowledge::from).collect(),
            start: header.true_start(),
            reference: ReferenceNoise::default(),
            kidnapped_at: header.kidnappings().map(|k| k.tick).collect(),
            jumps: Vec::with_capacity(header.kidnappings().count()),
            last_scan: None,
            thinned_from: None,
            stops: Vec::new(),
            beliefs: Vec::new(),
            sensed: None,
            from_log: false,
            origin: None,
            names,
        }
    }

    /// Whether an estimator (index of its name) reported a covariance.
    #[must_use]
    pub fn reports_covariance(&self, estimator: usize) -> bool {
        let mut estimates = self.stops.iter().filter_map(|stop| stop.estimate(estimator));
        estimates.any(|e| e.covariance.is_some())
    }

    /// Whether any of them did.
    #[must_use]
    pub fn has_covariances(&self) -> bool {
        (0..self.names.len()).any(|i| self.reports_covariance(i))
    }

    /// Adds a tick. `scan` holds ranges in m; `estimates` come in the order of
    /// `names`. Estimates that are missing at the end count as not given, and
    /// more of them than names are left aside.
    pub fn push(
        &mut self,
        time_s: f64,
        truth: Option<SE2>,
        scan: Option<&[f64]>,
        estimates: impl Iterator<Item = Option<SE2>>,
    ) {
        if let Some(ranges_m) = scan {
            let tick = self.tick_count();
            // One buffer for the whole run: only the last scan is ever drawn.
            let (at, kept) = self.last_scan.get_or_insert_with(Default::default);
            *at = tick;
            kept.clear();
            kept.extend_from_slice(ranges_m);
        }
        self.time_s.push(time_s);
        self.truth.push(truth);
        let mut estimates = estimates;
        for series in &mut self.estimates {
            series.push(estimates.next().flatten());
        }
    }

    /// The figures of the run, also where only some of its ticks are here.
    #[must_use]
    pub fn whole(&self) -> Whole {
        self.thinned_from.unwrap_or_else(|| Whole {
            ticks: self.tick_count() as u64,
            ticks_with_truth: self.ticks_with_truth() as u64,
            driven_m: distance_driven_m(self),
        })
    }

    /// Returns the report of the run, without pictures.
    #[must_use]
    pub fn report(&self, scores: Vec<Score>) -> ScoreReport {
        let whole = self.whole();
        ScoreReport {
            scenario: self.scenario.clone(),
            seed: self.seed,
            ticks: whole.ticks,
            ticks_with_truth: whole.ticks_with_truth,
            blocked_ticks: None,
            goals: None,
            reference: self.reference,
            digest: self.digest.clone(),
            scores,
            unscored: None,
            pictures: Vec::new(),
            report: None,
        }
    }

    /// Drops all estimators but these.
    pub fn keep_only(&mut self, names: &[String]) {
        fn keep<T>(list: &mut Vec<T>, kept: &[bool]) {
            let mut kept = kept.iter();
            list.retain(|_| kept.next() == Some(&true));
        }
        let kept: Vec<bool> = self.names.iter().map(|name| names.contains(name)).collect();
        keep(&mut self.names, &kept);
        keep(&mut self.told, &kept);
        keep(&mut self.estimates, &kept);
        self.stops.iter_mut().for_each(|stop| keep(&mut stop.estimates, &kept));
    }

    /// How many ticks there are.
    #[must_use]
    pub fn tick_count(&self) -> usize {
        self.time_s.len()
    }

    /// How many of them have a true pose that can be compared with.
    #[must_use]
    pub fn ticks_with_truth(&self) -> usize {
        (0..self.tick_count()).filter(|&tick| self.true_pose(tick).is_some()).count()
    }

    /// The true pose at a tick, if it is known and made of numbers.
    #[must_use]
    pub fn true_pose(&self, tick: usize) -> Option<SE2> {
        self.truth.get(tick).copied().flatten().filter(SE2::is_finite)
    }

    /// The pose an estimator believed in at a tick, if it gave one made of
    /// numbers. `estimator` is the index of its name.
    #[must_use]
    pub fn estimate(&self, estimator: usize, tick: usize) -> Option<SE2> {
        let series = self.estimates.get(estimator)?;
        series.get(tick).copied().flatten().filter(SE2::is_finite)
    }
}

/// Distance truly driven, m: the sum of the straight steps from the start, where it
/// is known, and each known true pose to the next.
#[must_use]
pub fn distance_driven_m(trace: &RunTrace) -> f64 {
    let mut path = PathLength::new(trace.start, trace.kidnapped_at.clone());
    for tick in 0..trace.tick_count() {
        trace.true_pose(tick).iter().for_each(|pose| path.push(tick as u64, pose));
    }
    path.metres()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A trace without walls and ticks.
    pub(crate) fn empty(names: &[&str]) -> RunTrace {
        RunTrace {
            scenario: "test".to_owned(),
            seed: Some(42),
            digest: "0123456789abcdef0123456789abcdef".to_owned(),
            world: WorldSpec {
                name: "open".to_owned(),
                bounds: [-50.0, -50.0, 50.0, 50.0],
                walls: Vec::new(),
                landmarks: Vec::new(),
            },
            lidar: LidarConfig::default(),
            names: names.iter().map(|&name| name.to_owned()).collect(),
            time_s: Vec::new(),
            is_in_ticks: false,
            truth: Vec::new(),
            estimates: vec![Vec::new(); names.len()],
            told: vec![PriorKnowledge::default(); names.len()],
            start: None,
            reference: ReferenceNoise::default(),
            kidnapped_at: Vec::new(),
            jumps: Vec::new(),
            last_scan: None,
            thinned_from: None,
            stops: Vec::new(),
            beliefs: Vec::new(),
            sensed: None,
            from_log: false,
            origin: None,
        }
    }

    /// The header of a run of the first scenario.
    pub(crate) fn header() -> LogHeader {
        let world = rusty_geometry::apartment().spec().clone();
        LogHeader::simulated("test", &rusty_contract::Scenario::default(), world)
    }

    #[test]
    fn every_list_has_one_entry_per_tick() {
        let mut trace = empty(&["a", "b"]);
        let here = Some(SE2::identity());
        trace.push(0.1, here, Some(&[1.0, 2.0]), [here, None].into_iter());
        trace.push(0.2, None, None, [here].into_iter());
        trace.push(0.3, here, Some(&[3.0]), [None, here, here].into_iter());
        assert_eq!(trace.tick_count(), 3);
        assert_eq!(trace.ticks_with_truth(), 2);
        assert_eq!(trace.estimates, [[here, here, None], [None, None, here]]);
        assert_eq!(trace.last_scan, Some((2, vec![3.0])));
    }

    #[test]
    fn a_pose_that_is_no_number_is_no_pose() {
        let mut trace = empty(&["a"]);
        let broken = Some(SE2::new(f64::NAN, 0.0, 0.0));
        trace.push(0.1, broken, None, [broken].into_iter());
        assert_eq!(trace.true_pose(0), None);
        assert_eq!(trace.estimate(0, 0), None);
        assert_eq!(trace.estimate(7, 0), None);
        assert_eq!(trace.estimate(0, 7), None);
        assert_eq!(trace.ticks_with_truth(), 0);
    }

    #[test]
    fn estimators_are_dropped_everywhere() {
        let mut trace = empty(&["a", "b", "c"]);
        let at = |x_m: f64| Some(SE2::new(x_m, 0.0, 0.0));
        trace.push(0.1, at(0.0), None, [at(1.0), at(2.0), at(3.0)].into_iter());
        let estimates = [1.0, 2.0, 3.0].map(|x_m| at(x_m).map(Into::into)).to_vec();
        trace.stops.push(Stop { estimates, ..Stop::default() });
        trace.keep_only(&["c".to_owned(), "a".to_owned()]);
        assert_eq!((trace.names.join(" "), trace.told.len()), ("a c".to_owned(), 2));
        assert_eq!(trace.estimates, [[at(1.0)], [at(3.0)]]);
        let stops = trace.stops[0].estimates.iter().map(|e| e.map(|e| e.pose_in_world));
        assert_eq!(stops.collect::<Vec<_>>(), [at(1.0), at(3.0)]);
    }

    #[test]
    fn a_header_gives_the_names_of_those_who_answer() {
        let trace = RunTrace::new(&header());
        assert_eq!(trace.names, ["dead-reckoning"]);
        assert_eq!(trace.estimates.len(), 1);
        assert_eq!((trace.scenario.as_str(), trace.seed), ("apartment", Some(42)));
    }
}
