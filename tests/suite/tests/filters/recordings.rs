//! SLAM on recordings of real robots, as they are and changed a little. The table of
//! docs/filters.md is printed, and compared with the page, by
//! `RUSTY_SEEDS=10 cargo test --release -p rusty-tests --test filters recordings:: -- --nocapture`.

use rusty_contract::log::TickRecord;
use rusty_contract::{Participant, Role, Start};
use rusty_filters::Random;
use rusty_filters::slam::{Slam, SlamOptions};
use rusty_metrics::alignment::aligned_errors;
use rusty_metrics::scored::Scored;
use rusty_tests::*;

/// Half of the range of the noise that a copy of a recording has, m.
const COPY_NOISE_M: f64 = 0.005;

/// How a copy of a recording differs from it.
#[derive(Clone, Copy, Debug)]
enum Change {
    Nothing,
    /// Noise in the ranges, with this seed.
    Noise(u64),
    /// One scan of N is kept, the first one.
    KeepOneOf(usize),
    /// Nothing comes back from farther away, m.
    CutAt(f64),
    /// A fifth of the beams ends anywhere before its wall, drawn from this seed.
    Shorten(u64),
}

impl Change {
    fn range_m(self, range_m: f64, range_max_m: f64, random: &mut Random) -> f64 {
        let is_echo = range_m < range_max_m;
        match self {
            Self::Noise(_) if is_echo => range_m + COPY_NOISE_M * (2.0 * random.uniform() - 1.0),
            Self::CutAt(cut_m) if range_m >= cut_m => range_max_m,
            Self::Shorten(_) if is_echo && random.uniform() < 0.2 => {
                range_m * (0.1 + 0.9 * random.uniform())
            }
            _ => range_m,
        }
    }

    fn keeps(self, scan: usize) -> bool {
        !matches!(self, Self::KeepOneOf(count) if !scan.is_multiple_of(count))
    }
}

/// Poses are at a place again if they are this near to each other, m, and this many key
/// scans apart.
const REVISIT: (f64, usize) = (2.0, 30);

/// What `slam` came to.
struct Outcome {
    /// ATE after the best rotation and translation of the answers when they were given, m.
    online_m: f64,
    /// The same of the key poses of the graph at the end.
    at_end_m: f64,
    /// Mean errors of these poses relative to each other, m: a metre of way apart, and at
    /// revisits (R. Kümmerle et al., *On measuring the accuracy of SLAM algorithms*,
    /// Autonomous Robots 27 (2009), with pairs of the reference instead of drawn ones).
    relations_m: [f64; 2],
}

impl Outcome {
    fn numbers(&self) -> Vec<f64> {
        vec![self.online_m, self.at_end_m]
    }
}

fn ate_m(pairs: impl Iterator<Item = (SE2, SE2)>) -> f64 {
    let scored =
        pairs.enumerate().map(|(tick, (estimate, truth))| Scored { tick, truth, estimate });
    let mut errors = aligned_errors(&scored.collect::<Vec<_>>()).unwrap();
    errors.figures().ate_rmse_m.unwrap()
}

/// The mean translational errors of poses relative to each other, m; NaN where none are.
/// Pairs are an estimate and its truth.
fn relations_m(keys: &[(SE2, SE2)]) -> [f64; 2] {
    let distance_m = |motion: SE2| motion.translation().norm();
    let error_m = |&(i, j): &(usize, usize)| {
        let [(a, true_a), (b, true_b)] = [keys[i], keys[j]];
        distance_m((true_a.inverse() * true_b).inverse() * (a.inverse() * b))
    };
    let apart_m = |i: usize, j: usize| distance_m(keys[i].1.inverse() * keys[j].1);
    let a_metre_on = |i: usize| {
        let mut way_m = 0.0;
        let is_there = |j: &usize| {
            way_m += apart_m(j - 1, *j);
            way_m >= 1.0
        };
        (i + 1..keys.len()).find(is_there).map(|j| (i, j))
    };
    let (near_m, scans) = REVISIT;
    let later = |i: usize| (i + scans..keys.len()).map(move |j| (i, j));
    let again = (0..keys.len()).flat_map(later).filter(|(i, j)| apart_m(*i, *j) < near_m);
    [(0..keys.len()).filter_map(a_metre_on).collect::<Vec<_>>(), again.collect()]
        .map(|pairs| pairs.iter().map(error_m).sum::<f64>() / pairs.len() as f64)
}

/// Runs `slam` on a changed copy of a recording.
fn slam(header: &LogHeader, records: &[TickRecord], roughness_m: f64, change: Change) -> Outcome {
    let participant = Participant::new("slam", Role::Estimator);
    let start = Start::new(header, header.roster.len(), &participant);
    let range_max_m = header.config.lidar.range_max_m;
    let mut options = SlamOptions::default();
    options.front.icp.roughness_m = roughness_m;
    let seed = if let Change::Noise(seed) | Change::Shorten(seed) = change { seed } else { 0 };
    let (mut slam, mut random) = (Slam::new(&start, &options), Random::new(seed, 1));
    let (mut answers, mut keys, mut scans) = (Vec::new(), Vec::new(), 0);
    for record in records {
        slam.advance(record.ticks);
        let Some(truth) = record.pose_in_world() else { continue };
        if let Some(ranges_m) = &record.ranges_m {
            scans += 1;
            if !change.keeps(scans - 1) {
                continue;
            }
            let changed = ranges_m.iter().map(|m| change.range_m(*m, range_max_m, &mut random));
            slam.scan(&changed.collect::<Vec<_>>());
            keys.extend((slam.map().count() > keys.len()).then_some(truth));
        }
        answers.push((slam.pose().0, truth));
    }
    let at_end: Vec<(SE2, SE2)> = slam.graph().poses().iter().copied().zip(keys).collect();
    let relations_m = relations_m(&at_end);
    let [online_m, at_end_m] = [answers, at_end].map(|pairs| ate_m(pairs.into_iter()));
    Outcome { online_m, at_end_m, relations_m }
}

/// Runs `slam` on a changed copy, and prints what comes out.
fn told(file: &str, log: &(LogHeader, Vec<TickRecord>), m: f64, change: Change) -> Outcome {
    let outcome = slam(&log.0, &log.1, m, change);
    println!(
        "{file:12} roughness {m:.3} m, {change:?}: online {:.2} m, at the end {:.2} m, \
         relations {:.3?} m",
        outcome.online_m, outcome.at_end_m, outcome.relations_m
    );
    outcome
}

fn imported(file: &str) -> Option<(LogHeader, Vec<TickRecord>)> {
    let data = real_data(&format!("{file}-corrected.log.gz"))?;
    let place = folder();
    let log = place.at("run.log");
    sim_server(&["import", "carmen", arg(&data), "-o", arg(&log)]).expect(0);
    Some(load(&log))
}

/// Neither the recording nor copies of it end farther off than `most_m`, and the page has
/// their figures.
fn check(file: &str, most_m: f64) {
    let Some(log) = imported(file) else { return };
    let seeds = crate::drivers::seeds(1);
    let outcomes = (0..=seeds).map(|seed| {
        let change = if seed == 0 { Change::Nothing } else { Change::Noise(seed) };
        let outcome = told(file, &log, 0.005, change);
        let Outcome { online_m, at_end_m, relations_m: [near_m, again_m] } = outcome;
        assert!(at_end_m < most_m && online_m < 1.2, "{file}, {change:?}: {online_m}, {at_end_m}");
        assert!(near_m < 0.055 && again_m < 0.1, "{file}, {change:?}: {near_m}, {again_m}");
        outcome
    });
    let mut outcomes: Vec<Outcome> = outcomes.collect();
    let recording = outcomes.remove(0);
    let mut rows = vec![
        ("recording".to_owned(), recording.numbers()),
        ("relations, 1 m apart / at revisits".to_owned(), recording.relations_m.to_vec()),
    ];
    if std::env::var_os("RUSTY_SEEDS").is_some() {
        rows.extend(changed(file, &log));
        // The page has the copies of ten seeds.
        if seeds == 10 {
            rows.extend(spread_rows("copies", &outcomes));
            let short = (1..=seeds).map(|seed| told(file, &log, 0.005, Change::Shorten(seed)));
            rows.extend(spread_rows("a fifth of the beams short", &short.collect::<Vec<_>>()));
        }
    }
    crate::figures::hold(file, &rows);
}

/// The rows of the page with the spread of outcomes.
fn spread_rows(row: &str, outcomes: &[Outcome]) -> [(String, Vec<f64>); 2] {
    let spread =
        |get: fn(&Outcome) -> f64| crate::figures::spread(outcomes.iter().map(get).collect());
    [
        (format!("{row}, online"), spread(|outcome| outcome.online_m)),
        (format!("{row}, final graph"), spread(|outcome| outcome.at_end_m)),
    ]
}

/// The rows of the page for other options and other changes.
fn changed(file: &str, log: &(LogHeader, Vec<TickRecord>)) -> Vec<(String, Vec<f64>)> {
    use Change::{CutAt, KeepOneOf};
    let rough = [0.015, 0.03, 0.05].map(|roughness_m| {
        let outcome = told(file, log, roughness_m, Change::Nothing);
        assert!(outcome.online_m < 1.2, "{file}: {} m", outcome.online_m);
        (format!("`--roughness-m {roughness_m}`"), outcome.numbers())
    });
    let others = [
        ("one scan of two", KeepOneOf(2)),
        ("one scan of three", KeepOneOf(3)),
        ("ranges cut at 8 m", CutAt(8.0)),
        ("ranges cut at 5 m", CutAt(5.0)),
    ];
    let others = others.map(|(row, change)| (row.into(), told(file, log, 0.005, change).numbers()));
    rough.into_iter().chain(others).collect()
}

#[test]
fn a_laser_that_sees_less_far_than_the_corridors_are_long() {
    let Some(log) = imported("freiburg-101") else { return };
    let outcome = told("freiburg-101", &log, 0.005, Change::CutAt(5.0));
    assert!(outcome.at_end_m < 0.35, "{} m", outcome.at_end_m);
}

#[test]
fn a_fifth_of_the_beams_ends_before_the_walls() {
    let Some(log) = imported("csail") else { return };
    let outcome = told("csail", &log, 0.005, Change::Shorten(1));
    let Outcome { online_m, at_end_m, .. } = outcome;
    assert!(online_m < 0.5 && at_end_m < 0.3, "{online_m} and {at_end_m} m");
}

#[test]
fn intel() {
    check("intel", 0.15);
}

#[test]
fn freiburg_101() {
    check("freiburg-101", 0.2);
}

#[test]
fn csail() {
    check("csail", 0.35);
}

#[test]
fn edmonton() {
    check("edmonton", 0.6);
}
