//! The footprint of a beam: the range at an edge is between both surfaces.
//!
//! A beam of full angle δ = [`divergence_rad`](LidarConfig::divergence_rad) lights a
//! spot. Where the spot covers an edge, both surfaces answer, and the LiDAR reports a
//! *mixed pixel*, a range between them. Here the range is the mean over 16 rays that
//! divide δ evenly, of those that return.
//!
//! Sources: M. Hebert and E. Krotkov, *3D measurements from imaging laser radars: how
//! good are they?*, Image and Vision Computing 10 (1992); J. Tuley, N. Vandapel and
//! M. Hebert, *Analysis and removal of artifacts in 3-D LADAR data*, ICRA 2005.
//!
//! Departures: the mean weighs by angle alone. Reflectance and distance of a surface
//! do not matter, and neither does the length of the pulse: a pulsed LiDAR mixes only
//! surfaces that are closer than its pulse, and one that measures a phase may report a
//! range outside of both. A beam whose outermost rays meet the same wall as its middle
//! keeps the range of its middle, so it does not see a post thinner than its spot.
//! People and other robots have no mixed pixels: they shorten the ray in the middle.

use nalgebra::Vector2;
use rusty_contract::LidarConfig;
use rusty_geometry::trig;

use super::glass::Rays;

/// Number of rays per footprint.
const RAYS: usize = 16;

/// Rays around a beam.
#[derive(Clone, Copy, Debug)]
pub(super) struct Footprint {
    /// Cosine and sine of the angle from the beam to each ray.
    turns: [[f64; 2]; RAYS],
}

impl Footprint {
    /// The footprint that `config` describes; `None` if beams have no width.
    pub(super) fn new(config: &LidarConfig) -> Option<Self> {
        let turns = std::array::from_fn(|i| {
            let share = (i as f64 + 0.5) / RAYS as f64 - 0.5;
            let (s, c) = trig::sin_cos(config.divergence_rad * share);
            [c, s]
        });
        (config.divergence_rad > 0.0).then_some(Self { turns })
    }

    /// The range of beam `beam` along `unit_dir`, whose middle meets `middle`, m;
    /// `None` if nothing returns.
    pub(super) fn range_m(
        &self,
        rays: &mut Rays<'_>,
        beam: usize,
        unit_dir: Vector2<f64>,
        middle: Option<(f64, usize)>,
    ) -> Option<f64> {
        let mut cast = |[c, s]: [f64; 2]| {
            let (x, y) = (unit_dir.x, unit_dir.y);
            rays.cast(beam, Vector2::new(c * x - s * y, s * x + c * y))
        };
        let wall = |hit: Option<(f64, usize)>| hit.map(|(_, wall)| wall);
        let mut is_other = |turn: [f64; 2]| wall(cast(turn)) != wall(middle);
        if !is_other(self.turns[0]) && !is_other(self.turns[RAYS - 1]) {
            return middle.map(|(range_m, _)| range_m);
        }
        let (mut sum_m, mut returned) = (0.0, 0.0);
        for (range_m, _) in self.turns.into_iter().filter_map(cast) {
            sum_m += range_m;
            returned += 1.0;
        }
        (returned > 0.0).then(|| sum_m / returned)
    }
}
