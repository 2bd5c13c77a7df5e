//! What a scan says of every particle.
//!
//! The likelihood of 180 beams is a needle: it is a few millimetres wide, and of
//! five thousand particles spread over a building none is that near to the
//! truth. *Probabilistic Robotics*, §8.3.6, knows that a sensor can be too good
//! for its particles, and blurs it. How much blur is right depends on how dense
//! the particles are, so there is a ladder: blurred fields of a few beams' worth
//! at its foot, all beams and the laser's own σ at its top, each rung half as wide
//! as the one below. A scan is weighed on the highest rung on which enough of
//! the particles survive it. (J. Deutscher, I. Reid, *Articulated Body Motion
//! Capture by Stochastic Search*, IJCV 61(2), 2005, who anneal in this way.)
//!
//! On a lower rung resampled particles would be copies of a few that happened to
//! be near, so they are spread again by half the width of that rung, as in
//! the regularised particle filter (C. Musso, N. Oudjane, F. Le Gland, in
//! *Sequential Monte Carlo Methods in Practice*, 2001). At the top, where a robot
//! is tracked, none of this takes place.

use std::sync::{Arc, OnceLock};

use nalgebra::Point2;
use rusty_geometry::{Material, SE2, Scan, Wall, World, trig};

use super::everywhere::{Everywhere, Fits};
use super::rays::Rays;
use super::recovery::hidden;
use super::{FreeSpace, Particles};
use crate::held::POSES;
use crate::likelihood_field::Ends;
use crate::resampling::{effective_size, normalise};
use crate::{BeamModel, Beams, DistanceField, LikelihoodField, OccupancyMap};

/// How many independent beams a scan is worth while the particles are too far
/// apart to tell its beams apart: a wrong pose moves the ends of all together.
pub(super) const BEAMS_WORTH: f64 = 8.0;
/// The most beams that are looked up in a blurred field.
const FEW: usize = 60;
/// The most blur, m: about the width of a door.
const MOST_BLUR_M: f64 = 0.4;
/// Which share of the particles has to survive a scan.
const SURVIVORS: f64 = 0.05;
/// By how much of a rung's width its survivors are spread.
const SPREAD: f64 = 0.5;
/// The most they are turned by, rad.
const MOST_TURN_RAD: f64 = 0.5;
/// σ of the field in which a scan is looked up everywhere, m.
const LOOK_UP_M: f64 = 0.1;
/// An end is on a wall in a field of at least this σ, m.
const WALL_M: f64 = 0.05;
/// The most places where it may fit,
const MOST_FITS: usize = 64;
/// and by how much less likely (ln p) a beam may be there than at the best one.
const WORSE: f64 = 0.6;
/// How often the likelihood is flattened beyond the lowest rung.
const MOST_HALVINGS: u32 = 8;

/// Side of a cell of the sharpest field, of σ.
const CELLS_PER_SIGMA: f64 = 2.0;

/// How a scan was taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weighed {
    /// Standard deviations (m, rad) by which those that are drawn next are to
    /// be moved; 0 at the top of the ladder.
    pub spread: (f64, f64),
    /// Likelihood of a beam under the belief after the scan: the geometric mean
    /// over beams and particles.
    pub beam_likelihood: f64,
}

/// The likelihoods by which the last scan was weighed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rung<'a> {
    /// ln p of the scan for every particle.
    pub logs: &'a [f64],
    /// The power to which the likelihood was raised.
    pub exponent: f64,
    /// How many beams the scan is then worth.
    pub worth: f64,
}

/// The fields of a map, and the scan that is being taken.
#[derive(Clone, Debug)]
pub struct Sensor {
    beams: Beams,
    skip: usize,
    exponent: f64,
    /// From the sharpest to the most blurred; runs on one map share them.
    fields: Arc<[LikelihoodField]>,
    /// Made when the robot is looked for everywhere.
    everywhere: Arc<OnceLock<Everywhere>>,
    /// The walls of glass.
    panes: Vec<Wall>,
    rays: Option<Rays>,
    ends: Ends,
    few: Ends,
    logs: Vec<f64>,
    prior: Vec<f64>,
    /// Exponent of the last scan, and how many beams that makes it worth.
    weighed_by: (f64, f64),
}

/// How a scan is to be made use of.
#[derive(Clone, Copy, Debug)]
pub struct Use {
    /// Every so-manieth beam is taken.
    pub skip: usize,
    /// The power to which the likelihood of all beams is raised.
    pub exponent: f64,
    /// Whether the beam model stands at the top of the ladder.
    pub rays: bool,
}

impl Sensor {
    /// For a floor plan. `scan` has the laser's beams.
    pub fn of_world(world: &World, model: BeamModel, beams: Beams, scan: Scan, how: Use) -> Self {
        let own_m = model.sigma_hit_m;
        let field = |sigma_m: f64| {
            let (blur_m, cell_m) = (blur(sigma_m, own_m), sigma_m / CELLS_PER_SIGMA);
            LikelihoodField::of_world(world, &model, beams.range_max_m, blur_m, cell_m)
        };
        // In a large world it is less sharp than the laser.
        let mut fields = vec![field(own_m)];
        fields.extend(blurred(fields[0].sigma_m()).map(field));
        let rays = how.rays.then(|| Rays::new(world.clone(), model, scan, beams.count()));
        let is_pane = |wall: &&Wall| wall.material == Material::Glass;
        let panes = world.walls().iter().filter(is_pane).copied().collect();
        Self { panes, ..Self::new(fields, rays, beams, how) }
    }

    /// For a map of cells, which has no rays.
    pub fn of_map(
        map: &OccupancyMap,
        distances: &DistanceField,
        model: &BeamModel,
        beams: Beams,
        how: Use,
    ) -> Self {
        let field =
            |blur_m| LikelihoodField::of_map(map, distances, model, beams.range_max_m, blur_m);
        // The sharpest field has the map's own error in it already.
        let mut fields = vec![field(0.0)];
        let own_m = fields[0].sigma_m();
        fields.extend(blurred(own_m).map(|sigma_m| field(blur(sigma_m, own_m))));
        Self::new(fields, None, beams, how)
    }

    fn new(fields: Vec<LikelihoodField>, rays: Option<Rays>, beams: Beams, how: Use) -> Self {
        Self {
            beams,
            skip: how.skip.max(1),
            exponent: how.exponent,
            fields: fields.into(),
            everywhere: Arc::default(),
            panes: Vec::new(),
            rays,
            ends: Ends::default(),
            few: Ends::default(),
            logs: Vec::new(),
            prior: Vec::new(),
            weighed_by: (1.0, 0.0),
        }
    }

    /// The likelihood of a beam that is to be expected at the right pose.
    pub fn expected_likelihood(&self) -> f64 {
        trig::exp(match &self.rays {
            None => self.fields[0].expected_log(),
            Some(rays) => rays.expected_log(self.beams.range_max_m),
        })
    }

    /// Takes a scan. Says whether it has anything to say: a beam that met
    /// something.
    fn take(&mut self, ranges_m: &[f64]) -> bool {
        let hits = || self.beams.every(self.skip, ranges_m).map(|end| end.in_body);
        self.ends.set(hits());
        let stride = self.ends.count().div_ceil(FEW).max(1);
        self.few.set(hits().step_by(stride));
        self.ends.count() > 0
    }

    /// The places of the map where a scan fits, and how well it fits `here`, which need not be
    /// on the map.
    pub(super) fn fits(&self, ranges_m: &[f64], space: &FreeSpace, here: Option<SE2>) -> Fits {
        let ends: Vec<Point2<f64>> =
            self.beams.endpoints(ranges_m).map(|end| end.in_body).collect();
        let stride = ends.len().div_ceil(FEW).max(1);
        let few: Vec<Point2<f64>> = ends.into_iter().step_by(stride).collect();
        let new = || Everywhere::new(self.blurred_by(LOOK_UP_M), space).with_glass(&self.panes);
        let everywhere = self.everywhere.get_or_init(new);
        let sensor = Point2::from(self.beams.sensor_in_body.translation());
        let mut fits = everywhere.best(&sensor, &few, MOST_FITS, WORSE);
        if let Some(here) = here {
            fits.add(everywhere.fit(&sensor, &few, here));
        }
        fits
    }

    /// The sharpest field that has this σ at least, or else the most blurred one.
    fn blurred_by(&self, sigma_m: f64) -> &LikelihoodField {
        let wide = self.fields.iter().find(|field| field.sigma_m() >= sigma_m);
        wide.unwrap_or(&self.fields[self.fields.len() - 1])
    }

    /// Share of the beams of the last scan that end on a wall of the map, seen from here.
    pub(super) fn on_walls(&self, pose_in_world: &SE2) -> f64 {
        let count = self.blurred_by(WALL_M).on_walls(&self.ends, pose_in_world);
        count as f64 / self.ends.count().max(1) as f64
    }

    /// Likelihood of a beam of the last scan, without those that end in front of all walls of the
    /// map ([`hidden`]), seen from here, where it is `likelihood` with them. The beam model
    /// explains those.
    pub(super) fn without_hidden(
        &self,
        ranges_m: &[f64],
        pose_in_world: &SE2,
        likelihood: f64,
    ) -> f64 {
        if self.rays.is_some() {
            return likelihood;
        }
        let field = self.blurred_by(WALL_M);
        let sensor_in_world = pose_in_world.compose(&self.beams.sensor_in_body);
        let sensor = Point2::from(sensor_in_world.translation());
        let is_in_front =
            |end: &Point2<f64>| field.is_in_front(&sensor, &pose_in_world.transform_point(end));
        let ends = self.beams.every(self.skip, ranges_m).map(|end| end.in_body);
        let mut in_front = Ends::default();
        in_front.set(ends.filter(is_in_front));
        if in_front.count() == 0 {
            return likelihood;
        }
        let (all, count) = (self.ends.count() as f64, in_front.count() as f64);
        let log_of_one = self.fields[0].log_likelihood(&in_front, pose_in_world) / count;
        let hidden = hidden(count, all);
        trig::exp((all * trig::ln(likelihood) - hidden * log_of_one) / (all - hidden))
    }

    /// ln p of a scan at each of these poses, and of how many beams. `None`: it says nothing.
    pub fn look_at(
        &mut self,
        ranges_m: &[f64],
        poses: &[SE2; POSES],
    ) -> Option<([f64; POSES], f64)> {
        let has_hits = self.take(ranges_m);
        let log = |pose| self.fields[0].log_likelihood(&self.ends, pose);
        has_hits.then(|| (poses.each_ref().map(log), self.ends.count() as f64))
    }

    /// Likelihood of a beam of this scan under the belief as it is: the geometric
    /// mean over beams and particles. `None` where it says nothing.
    pub fn beam_likelihood(&mut self, ranges_m: &[f64], particles: &Particles) -> Option<f64> {
        if particles.is_empty() || !self.take(ranges_m) {
            return None;
        }
        let beams = self.look_sharply(ranges_m, particles);
        Some(trig::exp(mean(&self.logs, &particles.weights) / beams))
    }

    /// Weighs the particles by a scan. `None`: it says nothing, because no beam
    /// met anything, and they weigh what they did.
    pub fn weigh(&mut self, ranges_m: &[f64], particles: &mut Particles) -> Option<Weighed> {
        if particles.is_empty() || !self.take(ranges_m) {
            return None;
        }
        self.prior.clone_from(&particles.weights);
        let beams = self.look_sharply(ranges_m, particles);
        let sharp = self.logs.clone();
        let width_m = self.climb(particles, beams);
        let mean_log = mean(&sharp, &particles.weights);
        let turn_rad = (SPREAD * width_m / self.ends.rms_m().max(1e-3)).min(MOST_TURN_RAD);
        Some(Weighed {
            spread: (SPREAD * width_m, turn_rad),
            beam_likelihood: trig::exp(mean_log / beams),
        })
    }

    /// ln p of the scan for every particle as sharply as can be, and of how many
    /// beams that is the sum.
    fn look_sharply(&mut self, ranges_m: &[f64], particles: &Particles) -> f64 {
        match &mut self.rays {
            None => {
                look_up(&self.fields[0], &self.ends, particles, &mut self.logs);
                self.ends.count() as f64
            }
            Some(rays) => rays.cast(&self.beams, self.skip, ranges_m, particles, &mut self.logs),
        }
    }

    /// Weighs on the highest rung that enough of them survive, and says how wide
    /// that is, m: 0 at the top.
    fn climb(&mut self, particles: &mut Particles, beams: f64) -> f64 {
        let enough = SURVIVORS * particles.count() as f64;
        let width = |sigma_m: f64, worth: f64| sigma_m / (0.5 * worth).max(1.0).sqrt();
        let least = (BEAMS_WORTH / beams).min(self.exponent);
        let mut exponent = self.exponent;
        loop {
            if survivors(&self.prior, &self.logs, exponent, &mut particles.weights) >= enough {
                let top = exponent >= self.exponent;
                let width_m = width(self.fields[0].sigma_m(), exponent * beams);
                self.weighed_by = (exponent, exponent * beams);
                return if top { 0.0 } else { width_m };
            }
            if exponent <= least {
                break;
            }
            exponent = (exponent / 4.0).max(least);
        }
        let (mut sigma_m, mut worth) = (self.fields[0].sigma_m(), exponent * beams);
        for field in &self.fields[1..] {
            let few = self.few.count() as f64;
            exponent = (BEAMS_WORTH / few).min(1.0);
            (sigma_m, worth) = (field.sigma_m(), exponent * few);
            look_up(field, &self.few, particles, &mut self.logs);
            if survivors(&self.prior, &self.logs, exponent, &mut particles.weights) >= enough {
                self.weighed_by = (exponent, worth);
                return width(sigma_m, worth);
            }
        }
        // Some are better than all others by more than such a scan should say.
        for _ in 0..MOST_HALVINGS {
            exponent *= 0.5;
            if survivors(&self.prior, &self.logs, exponent, &mut particles.weights) >= enough {
                break;
            }
        }
        self.weighed_by = (exponent, worth);
        width(sigma_m, worth)
    }

    /// The likelihoods by which the last scan was weighed, and the weights before it.
    pub(super) fn rung(&self) -> (Rung<'_>, &[f64]) {
        let (exponent, worth) = self.weighed_by;
        (Rung { logs: &self.logs, exponent, worth }, &self.prior)
    }
}

/// σ of the lower rungs of a ladder whose highest has this one, m: twice as
/// much, four times as much and so on. A highest rung that is wide already is the
/// only one.
fn blurred(sigma_m: f64) -> impl Iterator<Item = f64> {
    let sigmas = std::iter::successors(Some(2.0 * sigma_m), |sigma| Some(2.0 * sigma));
    sigmas.take_while(|sigma| *sigma <= MOST_BLUR_M)
}

/// What has to be added to `own_m` to make it `sigma_m`, as squares are.
fn blur(sigma_m: f64, own_m: f64) -> f64 {
    (sigma_m * sigma_m - own_m * own_m).sqrt()
}

/// Weighs by the likelihood to the power of `exponent`, and says how many
/// particles that leaves.
fn survivors(prior: &[f64], logs: &[f64], exponent: f64, weights: &mut [f64]) -> f64 {
    let best = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    for ((weight, prior), log) in weights.iter_mut().zip(prior).zip(logs) {
        *weight = prior * trig::exp(exponent * (log - best));
    }
    normalise(weights);
    effective_size(weights)
}

/// Mean by weights that add up to 1.
fn mean(values: &[f64], weights: &[f64]) -> f64 {
    values.iter().zip(weights).map(|(value, weight)| value * weight).sum()
}

/// ln p of these ends for every particle.
fn look_up(field: &LikelihoodField, ends: &Ends, particles: &Particles, logs: &mut Vec<f64>) {
    logs.clear();
    logs.extend((0..particles.count()).map(|k| {
        let (position, sin, cos) = particles.place(k);
        field.log_of_steps(field.steps_of_scan(ends, &position, sin, cos), ends.count())
    }));
}

#[cfg(test)]
#[path = "sensor_tests.rs"]
mod tests;
