//! A run that differs in one parameter differs only in that parameter.

mod common;

use common::{config, patrol_start, sim, steered};
use rusty_contract::{Frame, RunConfig};
use rusty_geometry::{EncoderCounts, apartment};
use rusty_sim::noise::LidarNoise;
use rusty_sim::{Lidar, Sim};

const TICKS: u64 = 120;

/// What one tick showed, and the truth behind it, as bits.
#[derive(Clone, Debug, PartialEq)]
struct Shown {
    truth: [u64; 3],
    ticks: EncoderCounts,
    command: [u64; 2],
    scan: Option<Vec<u64>>,
    digest: u64,
}

fn base() -> RunConfig {
    let mut config = config(steered(), &apartment(), patrol_start());
    config.seed = 42;
    config.robot.slip_std = 0.02;
    config.scan_every = 2;
    config
}

fn changed(change: impl FnOnce(&mut RunConfig)) -> Vec<Shown> {
    let mut config = base();
    change(&mut config);
    let mut sim = sim(config);
    let mut frame = Frame::boxed();
    (0..TICKS).map(|_| show(&mut sim, &mut frame)).collect()
}

fn show(sim: &mut Sim, frame: &mut Frame) -> Shown {
    let _ = sim.step(None, frame);
    let pose = sim.truth();
    Shown {
        truth: [pose.x(), pose.y(), pose.theta()].map(f64::to_bits),
        ticks: frame.encoders(),
        command: [frame.command().v_m_s, frame.command().omega_rad_s].map(f64::to_bits),
        scan: frame.ranges_m().map(|ranges_m| ranges_m.iter().map(|r| r.to_bits()).collect()),
        digest: frame.observable_digest(),
    }
}

fn assert_same_path(a: &[Shown], b: &[Shown]) {
    for (tick, (a, b)) in a.iter().zip(b).enumerate() {
        assert_eq!(a.truth, b.truth, "tick {tick}");
        assert_eq!((a.ticks, a.command), (b.ticks, b.command), "tick {tick}");
    }
}

#[test]
fn a_clone_goes_on_as_the_original_does() {
    let mut sim = sim(base());
    let mut frame = Frame::boxed();
    for _ in 0..37 {
        let _ = sim.step(None, &mut frame);
    }
    let mut twin = sim.clone();
    let mut other_frame = Frame::boxed();
    for _ in 0..40 {
        assert_eq!(show(&mut sim, &mut frame), show(&mut twin, &mut other_frame));
    }
}

#[test]
fn another_seed_is_another_run() {
    let (a, b) = (changed(|_| ()), changed(|c| c.seed = 43));
    for (a, b) in a.iter().zip(&b) {
        assert_ne!(a.truth, b.truth);
        assert_ne!(a.digest, b.digest);
    }
}

#[test]
fn one_more_beam_leaves_the_path_alone() {
    let (a, b) = (changed(|_| ()), changed(|c| c.lidar.beams = 181));
    assert_same_path(&a, &b);
    assert_eq!(b[0].scan.as_ref().map(Vec::len), Some(181));
    assert_ne!(a[0].digest, b[0].digest);
}

#[test]
fn one_more_beam_leaves_the_noise_of_the_others_alone() {
    // Beams half a degree apart from straight back: the first 180 of 360 have
    // the same bearings whether the circle or half of it is scanned.
    let half = changed(|c| c.lidar.fov_rad = std::f64::consts::PI);
    let full = changed(|c| c.lidar.beams = 360);
    for (half, full) in half.iter().zip(&full) {
        let (Some(half), Some(full)) = (&half.scan, &full.scan) else {
            continue;
        };
        assert_eq!(half[..], full[..180]);
    }
}

#[test]
fn dropout_leaves_the_beams_that_survive_alone() {
    let (all, some) = (changed(|_| ()), changed(|c| c.lidar.dropout = 0.2));
    assert_same_path(&all, &some);
    let (mut kept, mut lost) = (0, 0);
    for (all, some) in all.iter().zip(&some) {
        let (Some(all), Some(some)) = (&all.scan, &some.scan) else {
            assert_eq!(all.scan, some.scan);
            continue;
        };
        for (a, b) in all.iter().zip(some) {
            if a == b {
                kept += 1;
            } else {
                assert_eq!(f64::from_bits(*b), 8.0);
                lost += 1;
            }
        }
    }
    assert!(kept > 8000 && lost > 1800, "{kept} kept, {lost} lost");
}

#[test]
fn more_dropout_takes_more_of_the_same_beams() {
    let some = changed(|c| c.lidar.dropout = 0.2);
    let more = changed(|c| c.lidar.dropout = 0.3);
    let full_range = 8.0_f64.to_bits();
    for (some, more) in some.iter().zip(&more) {
        for (a, b) in some.scan.iter().flatten().zip(more.scan.iter().flatten()) {
            assert!(b == a || *b == full_range);
        }
    }
}

#[test]
fn the_scan_rate_leaves_path_and_scans_alone() {
    let often = changed(|c| c.scan_every = 1);
    for every in [2, 3, 7] {
        let seldom = changed(|c| c.scan_every = every);
        assert_same_path(&often, &seldom);
        for (tick, (often, seldom)) in often.iter().zip(&seldom).enumerate() {
            let due = (tick as u64).is_multiple_of(every);
            assert_eq!(seldom.scan.is_some(), due, "tick {tick}");
            assert!(!due || often == seldom, "tick {tick}");
        }
    }
    let never = changed(|c| c.scan_every = 0);
    assert_same_path(&often, &never);
    assert!(never.iter().all(|shown| shown.scan.is_none()));
}

#[test]
fn range_noise_leaves_the_path_alone_and_scales() {
    let perfect = changed(|c| c.lidar.range_std_m = 0.0);
    let good = changed(|c| c.lidar.range_std_m = 0.01);
    let poor = changed(|c| c.lidar.range_std_m = 0.02);
    assert_same_path(&perfect, &good);
    assert_same_path(&perfect, &poor);
    let scan = |shown: &Shown| shown.scan.clone().unwrap();
    let (z, g, p) = (scan(&perfect[0]), scan(&good[0]), scan(&poor[0]));
    for k in 0..180 {
        let [z, g, p] = [z[k], g[k], p[k]].map(f64::from_bits);
        if p < 7.9 && z < 7.9 {
            assert!((2.0 * (g - z) - (p - z)).abs() < 1e-14, "beam {k}");
        }
    }
}

#[test]
fn slip_leaves_the_noise_of_the_scans_alone() {
    // A robot that stands: slip has nothing to act on, whatever its size.
    let standing = |slip_std| {
        changed(|c| {
            c.script = rusty_contract::ScriptConfig::Driver {};
            c.robot.slip_std = slip_std;
        })
    };
    assert_eq!(standing(0.0), standing(0.5));
}

#[test]
fn a_scan_can_be_computed_alone() {
    let mut sim = sim(base());
    let mut lidar = Lidar::new(&sim.config().lidar);
    let mut frame = Frame::boxed();
    for tick in 0..60 {
        let _ = sim.step(None, &mut frame);
        let Some(shown_m) = frame.ranges_m() else {
            continue;
        };
        let mut alone_m = vec![f64::NAN; lidar.beams()];
        let mut noise = LidarNoise::new(sim.config().seed);
        lidar.scan(sim.world(), &sim.truth(), &mut noise, tick, &mut alone_m);
        assert_eq!(shown_m, alone_m, "tick {tick}");
        // Of another tick, all is different.
        lidar.scan(sim.world(), &sim.truth(), &mut noise, tick + 1, &mut alone_m);
        assert_ne!(shown_m, alone_m);
    }
}
