//! `cargo bench -p rusty-sim`: a tick of the world, with and without a scan, and
//! the noise of a scan.
#![allow(clippy::unwrap_used, reason = "a bench that cannot be set up may stop")]

use std::hint::black_box;

use criterion::{Criterion, Throughput};
use rusty_contract::{Frame, LidarConfig, RobotConfig, RunConfig, ScriptConfig};
use rusty_geometry::{SE2, apartment};
use rusty_sim::Sim;
use rusty_sim::noise::LidarNoise;

/// A figure of eight in the Apartment.
fn sim(scan_every: u64, beams: u32) -> Sim {
    let config = RunConfig {
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
        sensors: rusty_contract::Sensors::default(),
        kidnappings: Vec::new(),
        walkers: Vec::new(),
        crowd: None,
        events: Vec::new(),
    };
    Sim::new(config).unwrap()
}

fn main() {
    let mut criterion = Criterion::default().configure_from_args();
    let ways = [("without a scan", 0, 180), ("180 beams", 1, 180), ("1080 beams", 1, 1080)];
    let mut ticks = criterion.benchmark_group("tick");
    for (name, scan_every, beams) in ways {
        let (mut sim, mut frame) = (sim(scan_every, beams), Frame::boxed());
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
