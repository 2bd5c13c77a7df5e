//! Glass: a pane returns a beam, or lets it pass to the next surface.
//!
//! With the angle of incidence θ between beam and perpendicular, and α =
//! [`glass_visible_rad`](LidarConfig::glass_visible_rad), a pane returns a beam
//! with θ ≤ α. A beam with θ > α passes with probability T(θ), the share of
//! unpolarised light that a pane of refractive index n = 1.5 transmits:
//!
//! ```text
//! T = ½ Σ (1 − R) / (1 + R) over R_s and R_p, Fresnel's reflectances of one face
//! ```
//!
//! T is 0.923 at 0°, 0.848 at 60°, 0.618 at 75° and 0 at 90°.
//!
//! Sources: M. Born and E. Wolf, *Principles of Optics*, section 1.5 (Fresnel's
//! formulas); the sum of all reflections between two faces is that of G. G. Stokes
//! (1862). A LiDAR detects glass only from a narrow range of angles around the
//! perpendicular: P. Foster, Z. Sun, J. J. Park and B. Kuipers, *VisAGGE: Visible
//! Angle Grid for Glass Environments*, ICRA 2013.
//!
//! Departures: T is a share of light, and is taken as a probability. Light is
//! counted once, on the way out. VisAGGE learns the range of angles per cell of a
//! map; here α is one number of the LiDAR. The glass absorbs nothing. A beam that
//! does not pass returns from the pane, so there are no mirror images; in reality
//! most of it is reflected away. A beam that passes is not displaced. The ninth pane
//! on its way returns every beam. Every pane and scan decides anew.

use nalgebra::{Point2, Vector2};
use rusty_contract::LidarConfig;
use rusty_geometry::{Material, Wall, World, trig};

use crate::noise::LidarNoise;

/// Refractive index of window glass.
const INDEX: f64 = 1.5;

/// The share T(θ) of unpolarised light that a pane transmits, from the cosine of
/// the angle of incidence.
fn transmission(cos_incidence: f64) -> f64 {
    let sin_squared = 1.0 - cos_incidence * cos_incidence;
    let cos_inside = (1.0 - sin_squared / (INDEX * INDEX)).sqrt();
    let through = |a: f64, b: f64| {
        let amplitude = (a - b) / (a + b);
        let reflectance = amplitude * amplitude;
        (1.0 - reflectance) / (1.0 + reflectance)
    };
    let s = through(cos_incidence, INDEX * cos_inside);
    let p = through(INDEX * cos_incidence, cos_inside);
    0.5 * (s + p)
}

/// The glass as a LiDAR sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Glass {
    /// Cosine of α.
    cos_visible: f64,
}

impl Glass {
    /// The model that `config` describes; `None` if every pane returns every beam.
    pub(super) fn new(config: &LidarConfig) -> Option<Self> {
        let off = LidarConfig::default().glass_visible_rad;
        let cos_visible = trig::cos(config.glass_visible_rad);
        (config.glass_visible_rad < off).then_some(Self { cos_visible })
    }

    /// Probability that a beam along `unit_dir` passes a wall of any material.
    fn pass_probability(&self, wall: &Wall, unit_dir: &Vector2<f64>) -> f64 {
        if wall.material != Material::Glass {
            return 0.0;
        }
        let along = wall.b - wall.a;
        let cos_incidence = (unit_dir.perp(&along) / along.norm()).abs().min(1.0);
        if cos_incidence >= self.cos_visible { 0.0 } else { transmission(cos_incidence) }
    }
}

/// The rays of one scan.
pub(super) struct Rays<'a> {
    pub(super) world: &'a World,
    pub(super) origin: Point2<f64>,
    pub(super) max_m: f64,
    pub(super) glass: Option<Glass>,
    pub(super) noise: &'a mut LidarNoise,
    pub(super) tick: u64,
}

impl Rays<'_> {
    /// Distance and index of the wall that returns a ray of beam `beam`, if any.
    /// All rays of one beam have the same draws.
    pub(super) fn cast(&mut self, beam: usize, unit_dir: Vector2<f64>) -> Option<(f64, usize)> {
        let first = self.world.first_wall(self.origin, unit_dir, self.max_m)?;
        self.through_glass(beam, unit_dir, first)
    }

    /// The same for a ray whose first wall is known to be `hit`.
    pub(super) fn through_glass(
        &mut self,
        beam: usize,
        unit_dir: Vector2<f64>,
        mut hit: (f64, usize),
    ) -> Option<(f64, usize)> {
        let Some(glass) = self.glass else { return Some(hit) };
        for pane in 0.. {
            let wall = &self.world.walls()[hit.1];
            let probability = glass.pass_probability(wall, &unit_dir);
            if probability == 0.0 {
                break;
            }
            let draw = self.noise.at_pane(self.tick, beam, pane);
            if draw.is_none_or(|u| u >= probability) {
                break;
            }
            hit = self.world.next_wall(self.origin, unit_dir, self.max_m, hit)?;
        }
        Some(hit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::{FRAC_PI_2, PI};

    /// Fresnel's formulas in angles instead of cosines.
    fn by_angles(incidence_rad: f64) -> f64 {
        let inside_rad = trig::asin(trig::sin(incidence_rad) / 1.5);
        let (less, more) = (incidence_rad - inside_rad, incidence_rad + inside_rad);
        let square = |x: f64| x * x;
        let s = square(trig::sin(less) / trig::sin(more));
        let p = square(trig::tan(less) / trig::tan(more));
        0.5 * ((1.0 - s) / (1.0 + s) + (1.0 - p) / (1.0 + p))
    }

    #[test]
    fn the_law_is_that_of_fresnel() {
        assert!((transmission(1.0) - 12.0 / 13.0).abs() < 1e-15, "0.96 / 1.04 at 0 degrees");
        assert_eq!(transmission(0.0), 0.0);
        for k in 1..90 {
            let angle_rad = f64::from(k) * PI / 180.0;
            let found = transmission(trig::cos(angle_rad));
            assert!((found - by_angles(angle_rad)).abs() < 1e-12, "{k} degrees: {found}");
        }
        // The table of docs/sensors.md.
        for (degrees, expected) in
            [(30.0, 0.921), (45.0, 0.907), (60.0, 0.848), (75.0, 0.618), (85.0, 0.247)]
        {
            let found = transmission(trig::cos(degrees * PI / 180.0));
            assert!((found - expected).abs() < 0.0005, "{degrees} degrees: {found}");
        }
    }

    #[test]
    fn a_pane_seen_from_every_angle_is_a_wall() {
        let config = LidarConfig::default();
        assert!(Glass::new(&config).is_none());
        let glass_visible_rad = FRAC_PI_2.next_down();
        assert!(Glass::new(&LidarConfig { glass_visible_rad, ..config }).is_some());
    }
}
