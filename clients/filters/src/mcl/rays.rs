//! Particles weighed by the beam model.

use core::f64::consts::PI;

use rusty_geometry::{Scan, World, trig};

use super::Particles;
use crate::{BeamModel, Beams};

/// The beam model, which needs a ray for every beam and particle.
#[derive(Clone, Debug)]
pub(super) struct Rays {
    world: World,
    model: BeamModel,
    scan: Scan,
    expected_m: Vec<f64>,
    ranges_m: Vec<f64>,
}

impl Rays {
    /// For a floor plan and a laser with `beams` beams, those of `scan`.
    pub fn new(world: World, model: BeamModel, scan: Scan, beams: usize) -> Self {
        Self { world, model, scan, expected_m: vec![0.0; beams], ranges_m: Vec::new() }
    }

    /// ln p of a beam on average at the right pose: of hits, which are normal, of readings of
    /// nothing, and of those that lie anywhere.
    pub fn expected_log(&self, range_max_m: f64) -> f64 {
        let BeamModel { z_hit, z_max, z_short, z_rand, sigma_hit_m, .. } = self.model;
        let ln = |p: f64| trig::ln(p.max(1e-12));
        let peak = z_hit / ((2.0 * PI).sqrt() * sigma_hit_m);
        let strange = z_short + z_rand;
        z_hit * (ln(peak) - 0.5) + z_max * ln(z_max) + strange * ln(strange / range_max_m)
    }

    /// ln p of the scan for every particle, and of how many beams.
    pub fn cast(
        &mut self,
        beams: &Beams,
        skip: usize,
        ranges_m: &[f64],
        particles: &Particles,
        logs: &mut Vec<f64>,
    ) -> f64 {
        self.ranges_m.clear();
        self.ranges_m.extend(ranges_m.iter().take(beams.count()));
        // What lies beyond the longest range is that, as in all that reads scans.
        let is_range = |range_m: &f64| *range_m >= 0.0;
        let taken = self.ranges_m.iter().step_by(skip).filter(|r| is_range(r)).count();
        let range_max_m = beams.range_max_m;
        logs.clear();
        for k in 0..particles.count() {
            let sensor = particles.pose(k).compose(&beams.sensor_in_body);
            self.scan.take(&self.world, &sensor, range_max_m);
            self.scan.write_distances_m(&mut self.expected_m);
            let pairs = self.ranges_m.iter().zip(&self.expected_m).step_by(skip);
            let known = pairs.filter(|(range_m, _)| is_range(range_m));
            let log = |(range_m, expected_m): (&f64, &f64)| {
                let density = self.model.density(*range_m, *expected_m, range_max_m);
                trig::ln(density.max(1e-12))
            };
            logs.push(known.map(log).sum());
        }
        taken.max(1) as f64
    }
}
