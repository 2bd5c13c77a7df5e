//! Intervals that can be worked out by hand, and what pairing gains.

use rusty_sim::noise::TickNoise;

use super::super::fixtures::row;
use super::*;
use rusty_metrics::student::t_two_sided;

fn with(cell: usize, seed: u64, drift_m: f64) -> Row {
    Row { final_position_error_m: drift_m, ..row(cell, seed, "dead-reckoning") }
}

fn drift(rows: &[Row]) -> Paired {
    paired(rows, [0, 1]).swap_remove(0).paired
}

fn text(rows: &[Row]) -> String {
    paired(rows, [0, 1]).swap_remove(0).to_string()
}

#[test]
fn a_worked_example() {
    let (a, b) = ([1.0, 2.0, 3.0, 4.0], [1.5, 2.0, 3.5, 5.0]);
    let rows: Vec<Row> =
        (0..4).flat_map(|k| [with(0, k as u64, a[k]), with(1, k as u64, b[k])]).collect();
    let found = drift(&rows);
    assert_eq!((found.pairs, found.means), (4, [2.5, 3.0]));
    assert_eq!(found.difference, 0.5);
    // Differences 0.5, 0, 0.5, 1: variance 1/6, standard error √(1/24); t₃.
    let paired = 3.182_446_305 * (1.0_f64 / 24.0).sqrt();
    assert!((found.paired_half_width - paired).abs() < 1e-8, "{found:?}");
    // Variances 5/3 and 2.5: of the means 5/12 and 0.625; Welch's degrees 5.7692.
    let (va, vb) = (5.0 / 12.0, 0.625_f64);
    let degrees = (va + vb) * (va + vb) / (va * va / 3.0 + vb * vb / 3.0);
    assert!((degrees - 5.769_231).abs() < 1e-5, "{degrees}");
    let unpaired = t_two_sided(degrees, LEVEL) * (va + vb).sqrt();
    assert!((found.unpaired_half_width - unpaired).abs() < 1e-12);
    let factor = (unpaired / paired) * (unpaired / paired);
    assert!((found.variance_reduction - factor).abs() < 1e-6);
    assert!((found.correlation - 0.979_795_897).abs() < 1e-8, "{}", found.correlation);
}

#[test]
fn common_noise_gains_and_opposite_noise_loses() {
    // A is z; B is z and a little separate noise; or −z.
    let rows = |sign: f64| -> Vec<Row> {
        (0..400)
            .flat_map(|seed| {
                let [common, own] = TickNoise::slip(seed).normals(0);
                [with(0, seed, 5.0 + common), with(1, seed, 5.2 + sign * common + 0.1 * own)]
            })
            .collect()
    };
    let gain = drift(&rows(1.0));
    // Variances 1 and 1.01 against 0.01: a factor of 201.
    assert!((150.0..270.0).contains(&gain.variance_reduction), "{gain:?}");
    assert!(gain.correlation > 0.99);
    assert!(gain.difference - gain.paired_half_width > 0.0, "the paired interval tells them apart");
    assert!(gain.difference - gain.unpaired_half_width < 0.2 && gain.unpaired_half_width > 0.1);
    let loss = drift(&rows(-1.0));
    assert!((0.4..0.6).contains(&loss.variance_reduction), "{loss:?}");
}

#[test]
fn the_interval_holds_what_it_promises() {
    // 5 pairs with a true difference of 1: the interval misses it once in twenty.
    let missed = (0..2000_u64)
        .filter(|trial| {
            let rows: Vec<Row> = (0..5)
                .flat_map(|k| {
                    let [common, own] = TickNoise::slip(5 * trial + k).normals(0);
                    [with(0, k, 9.0 + common), with(1, k, 10.0 + common + own)]
                })
                .collect();
            let found = drift(&rows);
            (found.difference - 1.0).abs() > found.paired_half_width
        })
        .count();
    // 100 ± 10.
    assert!((60..140).contains(&missed), "{missed}");
}

#[test]
fn what_is_missing_in_one_is_named() {
    let mut rows: Vec<Row> =
        (0..30).flat_map(|seed| [with(0, seed, seed as f64), with(1, seed, 7.0)]).collect();
    rows.retain(|r| !(r.cell == 1 && (4..=15).contains(&r.seed)));
    rows[0].final_position_error_m = f64::NAN;
    let found = drift(&rows);
    assert_eq!(found.missing, [vec![0], (4..=15).collect::<Vec<u64>>()]);
    assert_eq!(found.pairs, 17);
    let text = text(&rows);
    assert!(text.contains("A lacks seed 0"), "{text}");
    assert!(text.contains("B lacks seeds 4, 5, 6, 7, 8, 9, 10, 11 and 4 more"), "{text}");
}

#[test]
fn the_text_says_what_was_shown() {
    let same: Vec<Row> = (0..9).flat_map(|s| [with(0, s, 1.0), with(1, s, 1.0)]).collect();
    assert!(text(&same).contains("no spread"));
    let one = [with(0, 1, 1.0), with(1, 1, 2.0)];
    assert!(drift(&one).paired_half_width.is_nan() && text(&one).contains("sweep more seeds"));
    let noise = |seed| TickNoise::slip(seed).normals::<2>(0);
    let apart: Vec<Row> =
        (0..9).flat_map(|s| [with(0, s, noise(s)[0]), with(1, s, noise(s)[1])]).collect();
    assert!(text(&apart).contains("no difference shown"));
    // Both figures of each estimator.
    assert_eq!(paired(&apart, [0, 1]).len(), 2);
    assert!(paired(&apart, [7, 8]).is_empty());
}

#[test]
fn cells_are_compared_two_by_two() {
    let rows: Vec<Row> =
        (0..4).flat_map(|cell| (0..3).map(move |seed| with(cell, seed, cell as f64))).collect();
    let config = super::super::fixtures::straight_leg();
    let cell = || crate::sweep::Cell { parameters: Vec::new().into(), config: config.clone() };
    let swept = Swept { cells: (0..4).map(|_| cell()).collect(), rows, tracks: Vec::new() };
    let found: Vec<([usize; 2], f64)> = ab(&swept)
        .into_iter()
        .filter(|p| p.figure == Figure::FinalPositionErrorM)
        .map(|p| (p.cells, p.paired.difference))
        .collect();
    assert_eq!(found, [([0, 1], 1.0), ([2, 3], 1.0)]);
}
