//! The budget reproduces the chapter's table.

use rusty_contract::RunConfig;

use super::*;

fn patrol(changes: &[&str]) -> RunConfig {
    let changes: Vec<String> = changes.iter().map(|c| (*c).to_owned()).collect();
    rusty_engine::scenario_file::load("patrol", &changes).unwrap().config().unwrap()
}

fn made(config: &RunConfig, seeds: &str) -> Report {
    budget(config, seeds.parse().unwrap(), &mut |_| true).unwrap().unwrap()
}

#[test]
fn the_rows_are_those_of_the_chapter() {
    // Where the world's own test of the table starts, for the last bits.
    let start = "start={ x_m = 6.0, y_m = 4.5, theta_rad = 0.0 }";
    let report = made(&patrol(&["robot.radius_bias_right=0.01", start]), "0..500");
    assert!((report.driven_m - 14.307).abs() < 1e-9);
    let [quantization, slip, radius] = &report.sources[..] else { panic!("three rows") };
    assert!((quantization.final_position_error_m.mean - 1.062_004_987_974e-4).abs() < 1e-12);
    assert!((quantization.final_heading_error_deg.mean - 0.008_512_397_770).abs() < 1e-9);
    assert!((radius.final_position_error_m.mean - 2.678_329_605_898).abs() < 1e-10);
    assert!((radius.final_heading_error_deg.mean - 49.265_017_954_97).abs() < 1e-9);
    // The bits that the world's own test of the slip row pins.
    let found = [
        slip.final_position_error_m.mean,
        slip.p95_final_position_error_m,
        slip.final_heading_error_deg.mean,
    ]
    .map(f64::to_bits);
    assert_eq!(found, [0x3fdd_455e_2326_5b0a, 0x3ff2_ae91_d122_e07d, 0x401c_cbc0_c4b6_a851]);
    assert_eq!([quantization, slip, radius].map(|l| l.varies_with_seed), [false, true, false]);
    assert_eq!([quantization, slip, radius].map(|l| l.runs), [1, 500, 1]);
    let shares: f64 = report.sources.iter().filter_map(|l| l.share).sum();
    assert!((shares - 1.0).abs() < 1e-12);
    assert!(radius.share > Some(0.9) && quantization.share < Some(1e-6));
    // Independent sources add up by their squares.
    let ratio = report.together.mean_square_m2.sqrt() / report.sum_of_squares_rms_m;
    assert!((0.9..1.1).contains(&ratio), "{ratio}");
    assert_eq!(report.absent, [Source::TrackBias]);
    let text = report.to_string();
    for part in ["14.31 m driven", "2.678 m", "49.27 °", "1.1e-4 m", "robot.track_bias=0.01"] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

#[test]
fn a_wrong_track_shows_in_turns_alone() {
    let report = made(&patrol(&["robot.slip_std=0", "robot.track_bias=0.01"]), "3");
    let [_, track] = &report.sources[..] else { panic!("two rows") };
    // 22 ticks of 0.31363 rad to the right, in which the robot turned less by
    // ε/(1 + ε).
    let expected_deg = (22.0 * 0.31363 * (1.0 - 1.0 / 1.01_f64)).to_degrees();
    assert!((track.final_heading_error_deg.mean - expected_deg).abs() < 0.02, "{track:?}");
    assert_eq!(report.absent, [Source::Slip, Source::RadiusBias]);
    // Alone and together are the same.
    assert_eq!(report.together.final_position_error_m, track.final_position_error_m);
}

#[test]
fn only_what_is_asked_for_is_changed() {
    let mut config = patrol(&["robot.radius_bias_right=0.01", "robot.track_bias=-0.02"]);
    config.robot.ticks_per_rev = 100;
    for source in Source::ALL {
        let alone = source.alone(&config);
        for other in Source::ALL {
            let stays = other == source || other == Source::Quantization;
            assert_eq!(other.is_in(&alone), stays, "{source:?} alone has {other:?}");
        }
        assert_eq!(
            RunConfig { robot: config.robot, ..alone },
            config,
            "{source:?} changes more than the robot"
        );
    }
}

#[test]
fn it_stops_when_told_to() {
    let mut calls = 0;
    let stopped = budget(&patrol(&[]), "0..500".parse().unwrap(), &mut |_| {
        calls += 1;
        calls < 3
    });
    assert_eq!(stopped.unwrap(), None);
    assert_eq!(calls, 3);
}

#[test]
fn runs_that_a_wall_blocked_are_counted() {
    let straight = "script={ kind = \"straight\", v_m_s = 0.5 }";
    let at = "start={ x_m = 6.0, y_m = 4.5, theta_rad = 0.0 }";
    let config = patrol(&["world=apartment", straight, at, "ticks=3000", "robot.slip_std=0.05"]);
    let report = made(&config, "0..20");
    let blocked = |report: &Report| {
        report.sources.iter().chain([&report.together]).map(|l| l.blocked_runs).collect::<Vec<_>>()
    };
    assert_eq!(blocked(&report), [1, 20, 20]);
    assert_eq!(report.to_string().matches("blocked the robot in").count(), 3);
    let free = made(&RunConfig { ticks: 100, ..config }, "0..20");
    assert_eq!(blocked(&free), [0, 0, 0]);
    assert!(!free.to_string().contains("blocked"));
    let have_shares = [report, free].map(|report| report.sources.iter().all(|l| l.share.is_some()));
    assert_eq!(have_shares, [false, true]);
}
