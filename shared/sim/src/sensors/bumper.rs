//! The bumper: where a blocked body touches.
//!
//! The sweep that blocks the robot is halved until the first contact is known to
//! 2⁻³⁰ of its length; the sectors of all walls and bodies that it touches there are set.
//!
//! Departures from a real one: the switch closes at the first touch, with no force,
//! and opens in the first tick in which nothing is in the way.

use nalgebra::Point2;
use rusty_contract::config::sensors::BumperConfig;
use rusty_geometry::{SE2, trig};

use crate::scene::Scene;

/// How often the way to the wall is halved.
const HALVINGS: u32 = 30;
/// How far a wall may be from the body to count as touched, m: far above rounding.
const TOUCH_M: f64 = 1e-6;

/// Contact sectors of the body.
#[derive(Clone, Copy, Debug)]
pub struct Bumper {
    config: BumperConfig,
    body_radius_m: f64,
}

impl Bumper {
    /// The bumper that `config` describes, around a body of this radius.
    #[must_use]
    pub fn new(config: &BumperConfig, body_radius_m: f64) -> Self {
        Self { config: *config, body_radius_m }
    }

    /// The sectors that touch, bit k for sector k: none where the robot was free
    /// to move, else those where its way from `pose` to `blocked_on_way_to` ends.
    #[must_use]
    pub fn read<'a>(
        &self,
        scene: impl Into<Scene<'a>>,
        pose: &SE2,
        blocked_on_way_to: Option<&SE2>,
    ) -> u16 {
        let scene = scene.into();
        let Some(to) = blocked_on_way_to else { return 0 };
        let way = to.boxminus(pose);
        let (mut free, mut blocked) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (free + blocked);
            if scene.blocks(pose, &pose.boxplus(&(way * middle)), self.body_radius_m) {
                blocked = middle;
            } else {
                free = middle;
            }
        }
        let contact = pose.boxplus(&(way * blocked));
        let mut sectors = 0;
        let reach_m = self.body_radius_m + TOUCH_M;
        let centre = Point2::from(contact.translation());
        scene.world.visit_near(centre, reach_m, |_, wall| {
            if wall.distance_squared(&centre) < reach_m * reach_m {
                let at = contact.inverse().transform_point(&wall.nearest(&centre));
                sectors |= self.sector(trig::atan2(at.y, at.x));
            }
        });
        for body in scene.bodies {
            let at = contact.inverse().transform_point(&body.centre);
            if trig::hypot(at.x, at.y) < reach_m + body.radius_m {
                sectors |= self.sector(trig::atan2(at.y, at.x));
            }
        }
        sectors
    }

    /// The bit of the sector at a bearing in the body frame; 0 outside of them.
    fn sector(&self, bearing_rad: f64) -> u16 {
        let BumperConfig { sectors, first_bearing_rad, fov_rad } = self.config;
        let turn = std::f64::consts::TAU;
        let mut from_first = (bearing_rad - first_bearing_rad) % turn;
        if from_first < 0.0 {
            from_first += turn;
            // Rounded up from a bearing just before the first one.
            if from_first == turn {
                from_first = 0.0;
            }
        }
        let k = (from_first / fov_rad * f64::from(sectors)) as u32;
        if from_first < fov_rad { 1 << k.min(sectors - 1) } else { 0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rusty_geometry::apartment;

    fn pressed(pose: SE2, ahead_m: f64) -> u16 {
        let config = BumperConfig::default();
        let to = pose.compose(&SE2::new(ahead_m, 0.0, 0.0));
        assert!(apartment().blocks(&pose, &to, 0.11));
        Bumper::new(&config, 0.11).read(&apartment(), &pose, Some(&to))
    }

    #[test]
    fn the_sector_that_faces_the_wall_is_set() {
        // The wall x = 12 of the living room, met head-on and at 40° to each side:
        // sectors of 36°, sector 2 straight ahead.
        assert_eq!(pressed(SE2::new(11.8, 3.0, 0.0), 0.2), 0b00100);
        let tilt_rad = 40f64.to_radians();
        assert_eq!(pressed(SE2::new(11.8, 3.0, tilt_rad), 0.3), 0b00010, "wall to the right");
        assert_eq!(pressed(SE2::new(11.8, 3.0, -tilt_rad), 0.3), 0b01000, "wall to the left");
    }

    #[test]
    fn a_free_robot_touches_nothing() {
        let bumper = Bumper::new(&BumperConfig::default(), 0.11);
        assert_eq!(bumper.read(&apartment(), &SE2::new(6.0, 4.5, 0.0), None), 0);
    }

    #[test]
    fn contact_behind_the_last_sector_is_not_seen() {
        // Backwards into the wall: the default has no sectors there.
        assert_eq!(pressed(SE2::new(11.8, 3.0, std::f64::consts::PI), -0.2), 0);
        let ring = BumperConfig { sectors: 8, first_bearing_rad: 0.0, fov_rad: 2.0 * 3.2 };
        let ring = BumperConfig { fov_rad: std::f64::consts::TAU, ..ring };
        let (pose, to) = (SE2::new(11.8, 3.0, 3.0), SE2::new(12.0, 3.0, 3.0));
        let bits = Bumper::new(&ring, 0.11).read(&apartment(), &pose, Some(&to));
        // The wall is at −3.0 rad of the body: sector ⌊(2π − 3)/(π/4)⌋ = 4.
        assert_eq!(bits, 1 << 4);
        // Just before the first bearing, by less than a rounding of 2π.
        let seam = Bumper::new(&ring, 0.11).sector(-1e-16);
        assert!(seam == 1 || seam == 1 << 7, "{seam}");
    }

    #[test]
    fn a_corner_is_felt_on_both_sides() {
        // Into the corner of the walls x = 12 and y = 6 along its diagonal.
        let [_, _, x_max, y_max] = apartment().bounds();
        let pose = SE2::new(x_max - 0.2, y_max - 0.2, std::f64::consts::FRAC_PI_4);
        let bits = pressed(pose, 0.3);
        assert_eq!(bits, 0b01010, "{bits:05b}");
    }
}
