//! Which share of a run's beams ends in front of the map: z_short of the beam model.
//!
//! Source: *Probabilistic Robotics*, §6.3.1, "unexpected objects". The map is that of
//! the start, which filters have: people, other robots, and walls and boxes that events
//! bring are in front of it.
//!
//! Departures: a beam counts as short if it reads less than the range of the map by more
//! than five deviations of its noise. The beam model also takes nearer ones for short,
//! and `fit-beam` weighs each by its likelihood. Where beams diverge, readings between
//! two surfaces count, too.

use rusty_contract::{Frame, LidarConfig, RunConfig};
use rusty_geometry::{SE2, Scan, World, trig};

/// Deviations of the noise by which a short reading is at least in front.
const DEVIATIONS: f64 = 5.0;

/// The beams of a run in which something may come in front of the map.
pub(super) struct ShortBeams {
    map: World,
    lidar: LidarConfig,
    scan: Scan,
    beams: u64,
    short: u64,
}

impl ShortBeams {
    /// Those of a run in `map`, the walls of its start; `None` if it has no scans, or
    /// nothing but its robot ever moves.
    pub fn of(config: &RunConfig, map: &World) -> Option<Self> {
        let moves = config.world_moves() || config.fleet.is_some();
        (moves && config.scan_every > 0).then(|| Self {
            map: map.clone(),
            lidar: config.lidar,
            scan: Scan::new(config.lidar.fan()),
            beams: 0,
            short: 0,
        })
    }

    /// Begins another run.
    pub fn clear(&mut self) {
        (self.beams, self.short) = (0, 0);
    }

    /// Takes a frame, and the pose at which it was taken.
    pub fn push(&mut self, frame: &Frame, body_in_world: &SE2) {
        let Some(ranges_m) = frame.ranges_m() else { return };
        let sensor_in_world = body_in_world.compose(&self.lidar.sensor_in_body);
        self.scan.take(&self.map, &sensor_in_world, self.lidar.range_max_m);
        let noise = (self.lidar.range_std_m, self.lidar.range_std_per_m);
        let is_short = |(range_m, expected_m): (f64, f64)| {
            range_m < expected_m - DEVIATIONS * trig::hypot(noise.0, noise.1 * expected_m)
        };
        let expected_m = self.scan.distances_and_walls().map(|(distance_m, _)| distance_m);
        let pairs = ranges_m.iter().copied().zip(expected_m);
        self.short += pairs.filter(|&pair| is_short(pair)).count() as u64;
        self.beams += ranges_m.len() as u64;
    }

    /// The share; NaN without a beam.
    pub fn share(&self) -> f64 {
        self.short as f64 / self.beams as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rusty_engine::scenario_file;
    use rusty_sim::Sim;

    fn share(people: u64) -> f64 {
        let changes = [format!("crowd.people={people}")];
        let config = scenario_file::load("office", &changes).unwrap().config().unwrap();
        let (mut sim, mut frame) = (Sim::new(config).unwrap(), Frame::boxed());
        let mut beams = ShortBeams::of(sim.config(), sim.world()).unwrap();
        for _ in 0..300 {
            let _ = sim.step(None, &mut frame);
            beams.push(&frame, &sim.truth());
        }
        beams.share()
    }

    #[test]
    fn more_people_make_more_short_beams_and_none_make_none() {
        let [none, few, many] = [0, 5, 20].map(share);
        assert!(none < 1e-4, "{none}");
        assert!(few > 0.01 && many > 2.0 * few && many < 0.6, "{few} {many}");
    }

    #[test]
    fn a_run_in_which_nothing_moves_has_no_share() {
        let config = scenario_file::load("apartment", &[]).unwrap().config().unwrap();
        let sim = Sim::new(config).unwrap();
        assert!(ShortBeams::of(sim.config(), sim.world()).is_none());
    }
}
