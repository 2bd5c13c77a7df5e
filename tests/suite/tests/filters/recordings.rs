//! SLAM on recordings of real robots, as they are and changed a little. The table of
//! docs/filters.md is printed by
//! `RUSTY_SEEDS=5 cargo test -p rusty-tests --test filters recordings:: -- --nocapture`.

use rusty_contract::log::TickRecord;
use rusty_contract::{Participant, Role, Start};
use rusty_filters::Random;
use rusty_filters::slam::{Slam, SlamOptions};
use rusty_metrics::alignment::aligned_errors;
use rusty_metrics::scored::Scored;
use rusty_tests::*;

/// Half of the range of the noise that a copy of a recording has, m.
const COPY_NOISE_M: f64 = 0.005;

/// ATE after the best rotation and translation, m.
struct Outcome {
    /// Of the answers when they were given.
    online_m: f64,
    /// Of the key poses of the graph at the end.
    at_end_m: f64,
}

fn ate_m(pairs: impl Iterator<Item = (SE2, SE2)>) -> f64 {
    let scored =
        pairs.enumerate().map(|(tick, (estimate, truth))| Scored { tick, truth, estimate });
    let mut errors = aligned_errors(&scored.collect::<Vec<_>>()).unwrap();
    errors.figures().ate_rmse_m.unwrap()
}

/// Runs `slam` on a recording. Copy 0 is the recording.
fn slam(header: &LogHeader, records: &[TickRecord], roughness_m: f64, copy: u64) -> Outcome {
    let participant = Participant::new("slam", Role::Estimator);
    let start = Start::new(header, header.roster.len(), &participant);
    let mut options = SlamOptions::default();
    options.front.icp.roughness_m = roughness_m;
    let (mut slam, mut random) = (Slam::new(&start, &options), Random::new(copy, 1));
    let (mut answers, mut keys) = (Vec::new(), Vec::new());
    for record in records {
        slam.advance(record.ticks);
        let Some(truth) = record.pose_in_world() else { continue };
        if let Some(ranges_m) = &record.ranges_m {
            let noisy = |range_m: &f64| {
                let is_echo = copy > 0 && *range_m < header.config.lidar.range_max_m;
                let noise_m = COPY_NOISE_M * (2.0 * random.uniform() - 1.0);
                if is_echo { range_m + noise_m } else { *range_m }
            };
            slam.scan(&ranges_m.iter().map(noisy).collect::<Vec<_>>());
            keys.extend((slam.map().count() > keys.len()).then_some(truth));
        }
        answers.push((slam.pose().0, truth));
    }
    let at_end = slam.graph().poses().iter().copied().zip(keys);
    Outcome { online_m: ate_m(answers.into_iter()), at_end_m: ate_m(at_end) }
}

/// Neither the recording nor copies of it end farther off than `most_m`.
fn check(file: &str, most_m: f64) {
    let Some(data) = real_data(&format!("{file}-corrected.log.gz")) else { return };
    let place = folder();
    let log = place.at("run.log");
    sim_server(&["import", "carmen", arg(&data), "-o", arg(&log)]).expect(0);
    let (header, records) = load(&log);
    let is_asked = std::env::var_os("RUSTY_SEEDS").is_some();
    let copies = (0..=crate::drivers::seeds(1)).map(|copy| (0.005, copy));
    let rougher = [0.015, 0.03, 0.05].into_iter().filter(|_| is_asked).map(|m| (m, 0));
    for (roughness_m, copy) in copies.chain(rougher) {
        let Outcome { online_m, at_end_m } = slam(&header, &records, roughness_m, copy);
        println!(
            "{file:12} roughness {roughness_m:.3} m, copy {copy}: online {online_m:.2} m, \
             at the end {at_end_m:.2} m"
        );
        assert!(roughness_m > 0.005 || at_end_m < most_m, "{file}, {copy}: {at_end_m} m");
        assert!(online_m < 1.2, "{file}, {copy}: {online_m} m");
    }
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
    check("edmonton", 0.5);
}
