//! Any sweep can be drawn, and the drawings say what they must.

use rusty_contract::RunConfig;
use rusty_geometry::SE2;
use rusty_plot::png;

use super::super::fixtures::{reckoned, straight_leg, track};
use super::super::{Cell, Sample, Swept, Track};
use super::*;

fn sweep(configs: Vec<RunConfig>, seeds: u64, every: u64) -> Swept {
    let tracks = configs
        .iter()
        .enumerate()
        .flat_map(|(cell, config)| (0..seeds).map(move |seed| reckoned(config, cell, seed, every)));
    let tracks: Vec<Track> = tracks.collect();
    let cells = configs.into_iter().map(|config| Cell {
        parameters: vec![("robot.slip_std".to_owned(), config.robot.slip_std.to_string())].into(),
        config,
    });
    Swept { cells: cells.collect(), rows: Vec::new(), tracks }
}

/// The chapter's laboratory of seeds with several slips.
fn slips(slips: &[f64], seeds: u64) -> Swept {
    let with = |&slip_std: &f64| {
        let mut config = straight_leg();
        config.robot.slip_std = slip_std;
        config
    };
    sweep(slips.iter().map(with).collect(), seeds, 1)
}

fn drawn(swept: &Swept) -> [String; 3] {
    let pages = [fan(swept), growth(swept), errors(swept)];
    for page in &pages {
        assert!(!page.contains("NaN") && !page.contains("inf\""), "a number that is none");
        assert!(png(page).unwrap().len() > 3_000);
    }
    // For a person who wants to look at them.
    if let Ok(folder) = std::env::var("RUSTY_DRAWINGS") {
        let name = format!("{}-{}", swept.cells.len(), swept.tracks.len());
        for (kind, page) in ["fan", "growth", "errors"].iter().zip(&pages) {
            let path = format!("{folder}/{kind}-{name}");
            std::fs::write(format!("{path}.svg"), page).unwrap();
            std::fs::write(format!("{path}.png"), png(page).unwrap()).unwrap();
        }
    }
    pages
}

#[test]
fn a_fan_has_a_panel_per_setting_and_a_growth_a_line() {
    let swept = slips(&[0.02, 0.05], 60);
    let [fan, growth, errors] = drawn(&swept);
    for part in [
        "Fan of patrol",
        "60 seeds, 0 to 59",
        "3.0 s",
        "robot.slip_std=0.02",
        "robot.slip_std=0.05",
        "believed by dead-reckoning",
        "x (m)",
        "y (m)",
    ] {
        assert!(fan.contains(part), "{part} is missing");
    }
    for part in [
        "How patrol comes apart",
        "spread across, log coordinates (m)",
        "spread of the heading (deg)",
        "distance driven (m)",
        "exponent across",
        "slope 1.5",
        "dead-reckoning, robot.slip_std=0.05",
    ] {
        assert!(growth.contains(part), "{part} is missing");
    }
    for part in [
        "Errors in patrol",
        "dead-reckoning, robot.slip_std=0.05",
        "position error (m)",
        "heading error (deg)",
        "no run has this figure",
    ] {
        assert!(errors.contains(part), "{part} is missing");
    }
    assert_eq!(drawn(&swept), [fan, growth, errors], "the same sweep, other bytes");
}

#[test]
fn a_patrol_in_the_apartment() {
    let loaded =
        rusty_engine::scenario_file::load("apartment", &["scan_every=0".to_owned()]).unwrap();
    let steered = loaded.config().unwrap();
    drawn(&sweep(vec![steered], 40, 25));
}

#[test]
fn bias_and_slip_side_by_side() {
    let with = |slip_std: f64, bias: f64| {
        let mut config = straight_leg();
        config.ticks = 60;
        config.robot.slip_std = slip_std;
        config.robot.radius_bias_right = bias;
        config
    };
    drawn(&sweep(vec![with(0.05, 0.0), with(0.05, 0.01), with(0.0, 0.01), with(0.0, 0.0)], 50, 1));
}

#[test]
fn odd_sweeps_can_be_drawn() {
    let none = Swept { cells: Vec::new(), rows: Vec::new(), tracks: Vec::new() };
    assert!(drawn(&none)[0].contains("no run has a track"));
    drawn(&slips(&[0.02], 1));
    let many = drawn(&slips(&[0.0, 0.01, 0.02, 0.03, 0.04, 0.05, 0.06, 0.07, 0.08], 3));
    assert!(many[0].contains("3 more settings not shown") && many[1].contains("1 more not shown"));
    let mut mad = slips(&[0.02], 9);
    mad.tracks[3].samples[7].estimate = SE2::new(f64::NAN, 1.0, 0.0);
    mad.tracks[4].samples[8].estimate = SE2::new(1e308, -1e308, 0.0);
    mad.tracks[5].samples.clear();
    mad.cells[0].config.scenario = "<&>\u{0}".repeat(60);
    drawn(&mad);
    let here = SE2::identity();
    let here = Sample { time_s: 1.0, distance_m: 0.0, truth: here, estimate: here, nees: None };
    let standing = (0..6).map(|seed| track(0, seed, vec![here; 5])).collect();
    drawn(&Swept { tracks: standing, ..slips(&[0.0], 0) });
}
