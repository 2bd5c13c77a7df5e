//! `cargo bench -p rusty-sim`: a tick of the world, with and without a scan, with
//! people and with sonars, and the noise of a scan.
#![allow(clippy::unwrap_used, reason = "a bench that cannot be set up may stop")]

use std::f64::consts::TAU;
use std::hint::black_box;

use criterion::{Criterion, Throughput};
use rusty_contract::config::CrowdConfig;
use rusty_contract::config::sensors::{SonarConfig, SonarModel};
use rusty_contract::{Frame, LidarConfig, RobotConfig, RunConfig, ScriptConfig, Sensors};
use rusty_geometry::{SE2, apartment, wrap_angle};
use rusty_sim::Sim;
use rusty_sim::noise::LidarNoise;

/// A figure of eight in the Apartment.
fn config(scan_every: u64, beams: u32) -> RunConfig {
    RunConfig {
        scenario: "bench".into(),
        seed: 42,
        ticks: 1000,
        dt_s: 0.02,
        scan_every,
        start: SE2::new(6.0, 4.5, 0.0),
        robot: RobotConfig::default(),
        lidar: LidarConfig { beams, ..LidarConfig::default() },
        script: ScriptConfig::FigureEight { v_m_s: 0.3, omega_rad_s: 0.6, half_s: 10.0 },
        world: apartment().spec().clone(),
        sensors: Sensors::default(),
        kidnappings: Vec::new(),
        walkers: Vec::new(),
        crowd: None,
        events: Vec::new(),
        fleet: None,
        patches: Vec::new(),
    }
}

/// A ring of 16 sonars with a reading in every tick.
fn sonars(model: SonarModel) -> Sensors {
    let mounts = (0..16u32).map(|k| SE2::new(0.0, 0.0, wrap_angle(f64::from(k) * TAU / 16.0)));
    let sonar = SonarConfig { mounts: mounts.collect(), model, every: 1, ..SonarConfig::default() };
    Sensors { sonar: Some(sonar), ..Sensors::default() }
}

fn main() {
    let mut criterion = Criterion::default().configure_from_args();
    let crowd = |people| Some(CrowdConfig { people, ..CrowdConfig::default() });
    let ways = [
        ("without a scan", config(0, 180)),
        ("180 beams", config(1, 180)),
        ("1080 beams", config(1, 1080)),
        ("20 people without a scan", RunConfig { crowd: crowd(20), ..config(0, 180) }),
        ("20 people, 180 beams", RunConfig { crowd: crowd(20), ..config(1, 180) }),
        ("16 sonars", RunConfig { sensors: sonars(SonarModel::Nearest), ..config(0, 180) }),
        (
            "16 sonars, specular",
            RunConfig { sensors: sonars(SonarModel::Specular), ..config(0, 180) },
        ),
    ];
    let mut ticks = criterion.benchmark_group("tick");
    for (name, config) in ways {
        let (mut sim, mut frame) = (Sim::new(config).unwrap(), Frame::boxed());
        ticks.bench_function(name, |bencher| {
            bencher.iter(|| black_box(sim.step(None, black_box(&mut frame))));
        });
    }
    ticks.finish();

    let mut noise = criterion.benchmark_group("noise of a scan");
    noise.throughput(Throughput::Elements(180));
    let (mut draws, mut tick) = (LidarNoise::new(1), 0);
    noise.bench_function("180 beams", |bencher| {
        bencher.iter(|| {
            tick += 1;
            draws.at(tick, 180).map(|draw| draw.u + draw.z).sum::<f64>()
        });
    });
    noise.finish();
    criterion.final_summary();
}
