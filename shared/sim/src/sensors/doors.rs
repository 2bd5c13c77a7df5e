//! The door detector: a sensor that is right with given probabilities.
//!
//! Source: S. Thrun, W. Burgard and D. Fox, *Probabilistic Robotics* (2005), section
//! 2.4.2 (a door sensor with p(sense open | open) = 0.6 and p(sense open | closed) =
//! 0.2) and the hallway of section 1.2; chapter 5 of the online course. Here a door of
//! the world that is in view is reported with the hit rate, one that is not with the
//! rate of false alarms, each by its number and independently.
//!
//! Departures: a door is in view where its middle is within range and field of view
//! and no wall, person or robot is before it.

use nalgebra::Point2;
use rusty_contract::config::sensors::DoorSensorConfig;
use rusty_contract::readings::MAX_DOORS;
use rusty_geometry::{Material, SE2, World};

use super::landmarks::in_view;
use crate::noise::TickNoise;
use crate::scene::Scene;

/// A detector of doors.
#[derive(Clone, Debug)]
pub struct DoorSensor {
    config: DoorSensorConfig,
    /// Number and middle of each door's walls, ascending by number.
    doors: Vec<(u8, Point2<f64>)>,
    noise: TickNoise,
    seen: [f64; MAX_DOORS],
}

impl DoorSensor {
    /// The detector that `config` describes, in `world`.
    #[must_use]
    pub fn new(config: &DoorSensorConfig, world: &World, seed: u64) -> Self {
        let doors = world.walls().iter().filter_map(|wall| match wall.material {
            Material::Door(number) => Some((number, nalgebra::center(&wall.a, &wall.b))),
            _ => None,
        });
        let mut doors: Vec<_> = doors.collect();
        doors.sort_by_key(|(number, _)| *number);
        Self { config: *config, doors, noise: TickNoise::doors(seed), seen: [0.0; MAX_DOORS] }
    }

    /// Goes on with the noise of another seed.
    pub fn reseed(&mut self, seed: u64) {
        self.noise = TickNoise::doors(seed);
    }

    /// The numbers of the doors that are reported in tick `tick`, ascending, at most
    /// [`MAX_DOORS`]; `None` in a tick without a reading.
    pub fn read<'a>(
        &mut self,
        scene: impl Into<Scene<'a>>,
        body_in_world: &SE2,
        tick: u64,
    ) -> Option<&[f64]> {
        let scene = scene.into();
        let Self { config, doors, noise, seen } = self;
        super::due(tick, config.every)?;
        let mut count = 0;
        for walls in doors.chunk_by(|a, b| a.0 == b.0) {
            let number = walls[0].0;
            let is_in_view = walls.iter().any(|(_, middle)| {
                in_view(&scene, body_in_world, middle, config.range_max_m, config.fov_rad).is_some()
            });
            let rate = if is_in_view { config.hit_rate } else { config.false_alarm_rate };
            if noise.uniform_at(tick, number.into()) < rate && count < MAX_DOORS {
                seen[count] = f64::from(number);
                count += 1;
            }
        }
        Some(&seen[..count])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rusty_geometry::hallway;

    #[test]
    fn rates_are_those_of_the_configuration() {
        let world = hallway();
        let config = DoorSensorConfig { every: 1, ..DoorSensorConfig::default() };
        let mut sensor = DoorSensor::new(&config, &world, 3);
        let (number, middle) = sensor.doors[0];
        // From half a metre before the first door, on whichever side is free.
        let before = [0.5, -0.5].map(|dy| SE2::new(middle.x, middle.y + dy, 0.0));
        let pose = before
            .into_iter()
            .find(|p| (0.0..).contains(&world.distance_to_nearest(Point2::from(p.translation()))))
            .unwrap();
        let ticks = 20_000;
        let mut reports = std::collections::BTreeMap::new();
        for tick in 0..ticks {
            for door in sensor.read(&world, &pose, tick).unwrap() {
                *reports.entry(*door as u8).or_insert(0) += 1;
            }
        }
        for (door, count) in reports {
            let rate = f64::from(count) / ticks as f64;
            let wanted = if door == number { 0.6 } else { 0.2 };
            assert!((rate - wanted).abs() < 0.015, "door {door}: {rate}");
        }
    }

    #[test]
    fn a_tick_between_readings_has_none() {
        let world = hallway();
        let mut sensor = DoorSensor::new(&DoorSensorConfig::default(), &world, 3);
        let pose = SE2::new(1.0, 1.0, 0.0);
        let has: Vec<bool> = (0..6).map(|t| sensor.read(&world, &pose, t).is_some()).collect();
        assert_eq!(has, [true, false, false, false, false, true]);
    }
}
