//! The small sensors, read after the motion of a tick in the order of
//! [`rusty_contract::readings`].
//!
//! To add one: its configuration in `rusty_contract::config::sensors`, its place in
//! `rusty_contract::readings`, a separate stream with slots in [`crate::noise`],
//! and a file here that cites its model.

mod bumper;
mod doors;
mod imu;
mod landmarks;
mod sonar;

use rusty_contract::{Frame, RunConfig};
use rusty_geometry::{SE2, World};

pub use bumper::Bumper;
pub use doors::DoorSensor;
pub use imu::Imu;
pub use landmarks::LandmarkSensor;
pub use sonar::Sonars;

use crate::outcome::StepOutcome;
use crate::scene::Scene;

/// `None` in a tick in which a sensor with one reading in `every` ticks has none.
fn due(tick: u64, every: u64) -> Option<()> {
    tick.is_multiple_of(every).then_some(())
}

/// What a tick did to the robot.
#[derive(Clone, Copy, Debug)]
pub struct Motion {
    /// True pose at the end of the tick, world frame.
    pub pose_in_world: SE2,
    /// Where the robot would be, had no wall been in its way; `None` where none was.
    pub blocked_on_way_to: Option<SE2>,
    /// Displacement.
    pub outcome: StepOutcome,
}

/// The small sensors of a robot, and what they remember.
#[derive(Clone, Debug)]
pub struct SmallSensors {
    bumper: Option<Bumper>,
    imu: Option<Imu>,
    sonars: Option<Sonars>,
    doors: Option<DoorSensor>,
    landmarks: Option<LandmarkSensor>,
}

impl SmallSensors {
    /// The sensors of `config` in `world`, before the first tick; `None` if it has
    /// none. The configuration must be checked.
    #[must_use]
    pub fn of(config: &RunConfig, world: &World) -> Option<Self> {
        let (sensors, seed) = (&config.sensors, config.robot_seed());
        let body_radius_m = config.robot.body_radius_m;
        (!sensors.is_none()).then(|| Self {
            bumper: sensors.bumper.map(|bumper| Bumper::new(&bumper, body_radius_m)),
            imu: sensors.imu.map(|imu| Imu::new(&imu, config.dt_s, seed)),
            sonars: sensors.sonar.as_ref().map(|sonar| Sonars::new(sonar, world, seed)),
            doors: sensors.doors.map(|doors| DoorSensor::new(&doors, world, seed)),
            landmarks: sensors.landmarks.map(|sensor| LandmarkSensor::new(&sensor, world, seed)),
        })
    }

    /// Back before the first tick, with another seed. Allocates nothing.
    pub fn restart(&mut self, seed: u64) {
        self.imu.iter_mut().for_each(|imu| imu.restart(seed));
        self.reseed(seed);
    }

    /// Goes on with the noise of another seed; what a sensor remembers stays.
    pub fn reseed(&mut self, seed: u64) {
        self.imu.iter_mut().for_each(|imu| imu.reseed(seed));
        self.sonars.iter_mut().for_each(|sonars| sonars.reseed(seed));
        self.doors.iter_mut().for_each(|doors| doors.reseed(seed));
        self.landmarks.iter_mut().for_each(|landmarks| landmarks.reseed(seed));
    }

    /// The walls are others from now on.
    pub fn walls_changed(&mut self, world: &World) {
        self.sonars.iter_mut().for_each(|sonars| sonars.walls_changed(world));
    }

    /// Writes what the sensors say at the end of tick `tick`. Allocates nothing.
    pub fn read(&mut self, scene: Scene<'_>, motion: &Motion, tick: u64, frame: &mut Frame) {
        let pose = &motion.pose_in_world;
        if let Some(bumper) = &self.bumper {
            frame.write_bumper(bumper.read(scene, pose, motion.blocked_on_way_to.as_ref()));
        }
        if let Some(imu) = &mut self.imu {
            frame.write_imu(imu.read(motion.outcome, tick));
        }
        if let Some(ranges_m) = self.sonars.as_mut().and_then(|s| s.read(scene, pose, tick)) {
            frame.write_sonars(ranges_m);
        }
        if let Some(doors) = self.doors.as_mut().and_then(|d| d.read(scene, pose, tick)) {
            frame.write_doors(doors);
        }
        if let Some(seen) = self.landmarks.as_mut().and_then(|l| l.read(scene, pose, tick)) {
            frame.write_landmarks(seen);
        }
    }
}
