//! `cargo bench -p rusty-geometry`: scans of worlds of growing size.
//!
//! `sim-server bench scan` measures the same ways in turns and prints ratios;
//! this is for working on them.
#![allow(clippy::unwrap_used, reason = "a bench that cannot be set up may stop")]

use std::f64::consts::TAU;
use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput};
use nalgebra::{Point2, Vector2};
use rusty_geometry::generated::{Density, Pattern, Recipe, free_poses};
use rusty_geometry::{Fan, SE2, Scan, World, apartment, trig};

const RANGE_MAX_M: f64 = 8.0;

/// The Apartment, and rooms at constant density.
fn worlds() -> Vec<World> {
    let rooms = [64, 512, 4096, 32_768].map(|walls| {
        let (pattern, density) = (Pattern::Rooms, Density::Constant);
        World::new(Recipe { pattern, density, walls, seed: 20 }.spec()).unwrap()
    });
    std::iter::once(apartment()).chain(rooms).collect()
}

/// A ray for each beam, in these directions of the sensor frame.
fn by_rays(world: &World, pose: &SE2, directions: &[Vector2<f64>]) -> f64 {
    let origin = Point2::from(pose.translation());
    let (s, c) = trig::sin_cos(pose.theta());
    let turn = |b: &Vector2<f64>| Vector2::new(c * b.x - s * b.y, s * b.x + c * b.y);
    let ranges_m = directions.iter().map(turn);
    ranges_m.map(|along| world.raycast_dir(origin, along, RANGE_MAX_M).distance_m).sum()
}

fn main() {
    let mut criterion = Criterion::default().configure_from_args();
    let worlds = worlds();
    for beams in [180_u32, 1080] {
        let mut group = criterion.benchmark_group(format!("scan of {beams} beams"));
        group.throughput(Throughput::Elements(u64::from(beams)));
        let fan = Fan { first_bearing_rad: 0.0, fov_rad: TAU, beams };
        let directions: Vec<_> = (0..beams).map(|k| fan.direction(k)).collect();
        for world in &worlds {
            let poses = free_poses(world, 20, 32, 0.1);
            let (mut scan, mut portable) = (Scan::new(fan), Scan::portable(fan));
            let mut turn = poses.iter().cycle();
            group.bench_function(BenchmarkId::new("kernel", world.name()), |bencher| {
                bencher.iter(|| turn.next().map(|pose| scan.take(world, pose, RANGE_MAX_M)));
            });
            group.bench_function(BenchmarkId::new("portable", world.name()), |bencher| {
                bencher.iter(|| turn.next().map(|pose| portable.take(world, pose, RANGE_MAX_M)));
            });
            group.bench_function(BenchmarkId::new("rays", world.name()), |bencher| {
                bencher
                    .iter(|| turn.next().map(|pose| black_box(by_rays(world, pose, &directions))));
            });
        }
    }
    criterion.final_summary();
}
