//! The belief of grid localisation: the masses of cells over x, y and heading.
//!
//! A layer has all cells of one heading. Its cells have one common offset from the grid,
//! and all headings have one common turn. A motion changes the offset and the turn, and
//! shifts a layer by whole cells where its offset is more than half a cell. So a motion
//! moves every cell exactly, and only its error spreads the masses.

use core::f64::consts::TAU;

use nalgebra::{Matrix3, Vector2, Vector3};
use rusty_geometry::{SE2, World, trig, wrap_angle};

use super::layer::{Layer, kernel};
use crate::likelihood_field::Ends;
use crate::mcl::Particles;
use crate::{GridFrame, LikelihoodField, Motion};

/// A cell with less than this share of the largest mass is left out.
const KEPT: f64 = 1e-8;
/// A cell with less than this share of the largest mass is not in a mode. The tails of a
/// mode belong to it: what a scan takes from them counts between modes.
const LIKELY: f64 = 1e-5;

/// A cell that a scan was looked up for.
#[derive(Clone, Copy, Debug)]
struct Seen {
    layer: u32,
    cell: u32,
    /// Mass before the scan.
    prior: f64,
    /// ln p of the scan.
    log: f64,
}

/// A histogram over x, y and heading.
#[derive(Clone, Debug)]
pub(super) struct Cells {
    frame: GridFrame,
    /// Cells of the grid that a body can be in.
    free: Vec<bool>,
    layers: Vec<Layer>,
    /// Empty layers, for the next belief.
    next: Vec<Layer>,
    /// Heading of layer 0, rad.
    turned_rad: f64,
    /// Cells that the last scan was looked up for.
    seen: Vec<Seen>,
    largest: f64,
    /// Of `seen`, those that may be in a mode.
    likely: Vec<u32>,
}

impl Cells {
    /// Number of cells, with all headings, that a plan needs.
    pub(super) fn count(world: &World, cell_m: f64, headings: usize) -> usize {
        GridFrame::covering(world.bounds(), 0.0, cell_m).cells().saturating_mul(headings)
    }

    /// No belief yet. A cell is free if a body of this radius touches nothing somewhere in it.
    pub(super) fn of_world(
        world: &World,
        cell_m: f64,
        headings: usize,
        body_radius_m: f64,
    ) -> Self {
        let frame = GridFrame::covering(world.bounds(), 0.0, cell_m);
        let clear_m = body_radius_m - 0.5 * 2.0_f64.sqrt() * cell_m;
        let is_free = |cell| world.distance_to_nearest(frame.centre(cell)) >= clear_m;
        let free = (0..frame.cells()).map(is_free).collect();
        Self::new(frame, free, headings)
    }

    pub(super) fn new(frame: GridFrame, free: Vec<bool>, headings: usize) -> Self {
        let masses = vec![0.0; frame.cells()];
        let layers = vec![Layer { offset_m: Vector2::zeros(), masses, rows: 0..0 }; headings];
        let next = layers.clone();
        Self {
            frame,
            free,
            layers,
            next,
            turned_rad: 0.0,
            seen: Vec::new(),
            largest: 0.0,
            likely: Vec::new(),
        }
    }

    /// Number of free cells, with all headings.
    pub(super) fn free_count(&self) -> usize {
        self.free.iter().filter(|is_free| **is_free).count() * self.layers.len()
    }

    /// Side of the cells, m.
    pub(super) fn cell_m(&self) -> f64 {
        self.frame.cell_m
    }

    /// Angle from layer to layer, rad.
    pub(super) fn turn_rad(&self) -> f64 {
        TAU / self.layers.len() as f64
    }

    fn heading_rad(&self, layer: usize) -> f64 {
        wrap_angle(self.turned_rad + layer as f64 * self.turn_rad())
    }

    fn pose(&self, layer: usize, cell: usize) -> SE2 {
        let at = self.frame.centre(cell) + self.layers[layer].offset_m;
        SE2::new(at.x, at.y, self.heading_rad(layer))
    }

    /// Begins at a normal law (σ in m and rad). One cell has exactly this mean.
    pub(super) fn fill_around(&mut self, mean: &SE2, sigma_m: f64, sigma_rad: f64) {
        let (frame, turn_rad) = (self.frame, self.turn_rad());
        let (column, row) = frame.column_row(mean.translation().into());
        let nearest = frame
            .index(column.clamp(0, frame.width as i64 - 1), row.clamp(0, frame.height as i64 - 1));
        let centre = frame.centre(nearest.unwrap_or(0));
        self.turned_rad = wrap_angle(mean.theta());
        let headings = self.layers.len();
        for (j, layer) in self.layers.iter_mut().enumerate() {
            layer.clear(frame.width);
            layer.offset_m = mean.translation() - centre.coords;
            let turns = j.min(headings - j) as f64 * turn_rad / sigma_rad;
            for cell in 0..frame.cells() {
                let squares = (frame.centre(cell) - centre).norm_squared() / (sigma_m * sigma_m);
                layer.add(&frame, cell, (0, 0), trig::exp(-0.5 * (squares + turns * turns)));
            }
        }
        self.normalise();
    }

    /// Mixes the belief with this share of the uniform law over all free cells.
    pub(super) fn mix(&mut self, share: f64) {
        let each = share / self.free_count().max(1) as f64;
        for layer in &mut self.layers {
            for (mass, is_free) in layer.masses.iter_mut().zip(&self.free) {
                *mass = *mass * (1.0 - share) + if *is_free { each } else { 0.0 };
            }
            layer.rows = 0..self.frame.height;
        }
    }

    /// Predicts (Table 8.1, line 3): moves all cells by a motion and spreads them by its
    /// error, and by `more` (cells², in each direction).
    pub(super) fn move_by(&mut self, motion: &Motion, more: f64) {
        let (way, frame) = (motion.now_in_then.translation(), self.frame);
        for j in 0..self.layers.len() {
            let (sin, cos) = trig::sin_cos(self.heading_rad(j));
            let way_m = Vector2::new(cos * way.x - sin * way.y, sin * way.x + cos * way.y);
            self.layers[j].move_by(&frame, way_m, &mut self.next[j]);
        }
        self.turned_rad = wrap_angle(self.turned_rad + motion.now_in_then.theta());
        self.spread(&motion.covariance, more);
    }

    /// Spreads by a covariance in the body frame (m, m, rad) and `more` cells².
    fn spread(&mut self, covariance: &Matrix3<f64>, more: f64) {
        let cell_m2 = self.frame.cell_m * self.frame.cell_m;
        let [xx, xy, yy] = [(0, 0), (0, 1), (1, 1)].map(|at| covariance[at] / cell_m2);
        for j in 0..self.layers.len() {
            let (s, c) = trig::sin_cos(self.heading_rad(j));
            let along_x = c * c * xx - 2.0 * s * c * xy + s * s * yy;
            let along_y = s * s * xx + 2.0 * s * c * xy + c * c * yy;
            self.layers[j].spread(&self.frame, [along_x + more, along_y + more]);
        }
        let turn_rad = self.turn_rad();
        let (times, share) = kernel(covariance[(2, 2)] / (turn_rad * turn_rad) + more);
        for _ in 0..times {
            self.spread_headings(share);
        }
    }

    /// Gives this share of each layer to each of the two next to it.
    fn spread_headings(&mut self, share: f64) {
        let headings = self.layers.len();
        for (next, layer) in self.next.iter_mut().zip(&self.layers) {
            next.offset_m = layer.offset_m;
        }
        for (j, layer) in self.layers.iter().enumerate() {
            self.next[j].add_layer(&self.frame, layer, 1.0 - 2.0 * share);
            for neighbour in [(j + 1) % headings, (j + headings - 1) % headings] {
                self.next[neighbour].add_layer(&self.frame, layer, share);
            }
        }
        std::mem::swap(&mut self.layers, &mut self.next);
        let width = self.frame.width;
        self.next.iter_mut().for_each(|layer| layer.clear(width));
    }

    /// Corrects (Table 8.1, line 4) by a scan, whose likelihood has this exponent. Returns
    /// the likelihood of a beam: the geometric mean over the beams and over the belief after
    /// the scan.
    pub(super) fn correct(&mut self, field: &LikelihoodField, ends: &Ends, exponent: f64) -> f64 {
        let width = self.frame.width;
        let mut best = f64::NEG_INFINITY;
        self.seen.clear();
        for j in 0..self.layers.len() {
            let (sin, cos) = trig::sin_cos(self.heading_rad(j));
            let layer = &mut self.layers[j];
            for cell in layer.rows.start * width..layer.rows.end * width {
                let prior = layer.masses[cell];
                if !self.free[cell] {
                    layer.masses[cell] = 0.0;
                } else if prior > 0.0 {
                    let at = self.frame.centre(cell).coords + layer.offset_m;
                    let steps = field.steps_of_scan(ends, &at, sin, cos);
                    let log = field.log_of_steps(steps, ends.count());
                    best = best.max(log);
                    self.seen.push(Seen { layer: j as u32, cell: cell as u32, prior, log });
                }
            }
        }
        let (mut sum, mut sum_of_logs) = (0.0, 0.0);
        for seen in &self.seen {
            let mass = seen.prior * trig::exp(exponent * (seen.log - best));
            self.layers[seen.layer as usize].masses[seen.cell as usize] = mass;
            sum += mass;
            sum_of_logs += mass * seen.log;
        }
        self.normalise();
        if sum > 0.0 { trig::exp(sum_of_logs / sum / ends.count().max(1) as f64) } else { 0.0 }
    }

    /// Leaves out cells with hardly any mass, and makes the sum 1. Without any mass the
    /// robot may be anywhere.
    fn normalise(&mut self) {
        let width = self.frame.width;
        let masses = || self.layers.iter().flat_map(|l| l.occupied(width)).map(|(_, mass)| mass);
        let largest = masses().fold(0.0, f64::max);
        let least = KEPT * largest;
        let sum: f64 = masses().filter(|mass| *mass >= least).sum();
        if !(sum > 0.0 && sum.is_finite()) {
            self.layers.iter_mut().for_each(|layer| layer.clear(width));
            self.mix(1.0);
            self.largest = 1.0 / self.free_count().max(1) as f64;
            return;
        }
        for layer in &mut self.layers {
            let mut rows = 0..0;
            for row in layer.rows.clone() {
                let mut has_mass = false;
                for mass in &mut layer.masses[row * width..(row + 1) * width] {
                    *mass = if *mass >= least { *mass / sum } else { 0.0 };
                    has_mass |= *mass > 0.0;
                }
                if has_mass {
                    rows = if rows.is_empty() { row } else { rows.start }..row + 1;
                }
            }
            layer.rows = rows;
        }
        self.largest = largest / sum;
    }

    /// Puts the cells that may be in a mode after a scan into `particles`, weighted by their
    /// masses.
    pub(super) fn write_likely(&mut self, particles: &mut Particles) {
        particles.clear();
        self.likely.clear();
        for (k, seen) in self.seen.iter().enumerate() {
            let (layer, cell) = (seen.layer as usize, seen.cell as usize);
            let mass = self.layers[layer].masses[cell];
            if mass >= LIKELY * self.largest {
                self.likely.push(k as u32);
                particles.push(&self.pose(layer, cell));
                particles.weights[self.likely.len() - 1] = mass;
            }
        }
    }

    /// Masses of the likely cells before the scan.
    pub(super) fn priors(&self) -> impl Iterator<Item = f64> + '_ {
        self.likely.iter().map(|k| self.seen[*k as usize].prior)
    }

    /// Multiplies the masses of the likely cells, and makes the sum 1.
    pub(super) fn scale(&mut self, factors: impl Iterator<Item = f64>) {
        for (k, factor) in self.likely.iter().zip(factors) {
            let seen = self.seen[*k as usize];
            self.layers[seen.layer as usize].masses[seen.cell as usize] *= factor;
        }
        self.normalise();
    }

    /// Variances of a pose that is anywhere in its cell (m², m², rad²).
    pub(super) fn within_cell(&self) -> Vector3<f64> {
        let (cell_m, turn_rad) = (self.frame.cell_m, self.turn_rad());
        Vector3::new(cell_m * cell_m, cell_m * cell_m, turn_rad * turn_rad) / 12.0
    }
}

#[cfg(test)]
#[path = "cells_tests.rs"]
mod tests;
