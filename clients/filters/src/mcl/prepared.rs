//! What map and laser become before a run.

use rusty_clients::ClientError;
use rusty_contract::Start;
use rusty_contract::config::LidarConfig;
use rusty_geometry::{DiffDrive, Scan, World};

use super::sensor::{Sensor, Use};
use super::{FreeSpace, Model, Options};
use crate::beams::believed_lidar;
use crate::{Beams, DistanceField, OccupancyMap};

/// The map to localise in.
#[derive(Clone, Debug)]
pub enum Map {
    /// A floor plan.
    Plan(Box<World>),
    /// A map of cells.
    Cells(OccupancyMap),
}

/// What the filter has to know of robot and laser.
#[derive(Clone, Copy, Debug)]
pub struct Robot {
    /// Its wheels.
    pub drive: DiffDrive,
    /// Radius of its body, m.
    pub body_radius_m: f64,
    /// Its laser.
    pub lidar: LidarConfig,
    /// How long before its end the first tick began, s.
    pub dt_s: f64,
}

impl Robot {
    /// The robot that a filter is told of.
    pub(super) fn of_start(start: &Start) -> Self {
        Self {
            drive: start.robot.drive,
            body_radius_m: start.robot.body_radius_m,
            lidar: believed_lidar(start),
            dt_s: start.dt_s,
        }
    }
}

/// What a map becomes, for the next run on it.
#[derive(Debug)]
pub struct Prepared {
    /// What the filter was told, without what changes from run to run.
    told: Start,
    sensor: Sensor,
    space: FreeSpace,
}

impl Prepared {
    /// The parts of a run: those of the last one where all is told that was told then.
    pub(super) fn parts(
        robot: &Robot,
        start: &Start,
        options: &Options,
        prepared: &mut Option<Self>,
    ) -> Result<(Sensor, FreeSpace), ClientError> {
        let told = Start { initial_pose: None, ..start.without_run() };
        let known = prepared.take().filter(|known| known.told == told && options.map.is_none());
        let known = match known {
            Some(known) => known,
            None => {
                let (sensor, space) = sense(robot, map(start, options)?, options)?;
                Self { told, sensor, space }
            }
        };
        let parts = (known.sensor.clone(), known.space.clone());
        *prepared = Some(known);
        Ok(parts)
    }
}

/// The map that a filter was given.
fn map(start: &Start, options: &Options) -> Result<Map, ClientError> {
    let unusable = |text: String| ClientError::Unusable(text);
    match (&options.map, &start.map) {
        #[cfg(not(feature = "link"))]
        (Some(path), _) => {
            let problem = "no files are read in this build; leave --map out";
            Err(unusable(format!("--map {}: {problem}", path.display())))
        }
        #[cfg(feature = "link")]
        (Some(path), _) => {
            Ok(Map::Cells(OccupancyMap::load(path).map_err(|e| unusable(e.to_string()))?))
        }
        (None, Some(spec)) => {
            let world = World::new(spec.clone()).map_err(|e| unusable(e.to_string()))?;
            Ok(Map::Plan(Box::new(world)))
        }
        (None, None) => Err(unusable(
            "there is no map to localise in: give the participant `map = \"given\"` in \
                 the scenario, or a map with --map FILE.yaml"
                .to_owned(),
        )),
    }
}

/// What a map becomes: what a scan says on it, and where the robot can be.
pub(super) fn sense(
    robot: &Robot,
    map: Map,
    options: &Options,
) -> Result<(Sensor, FreeSpace), ClientError> {
    if options.least() > options.particles {
        return Err(ClientError::Usage(format!(
            "--particles-min {} is more than --particles {}, the most there may be: give \
             fewer of the one or more of the other",
            options.least(),
            options.particles
        )));
    }
    let Robot { body_radius_m, lidar, .. } = *robot;
    let model = options.reading.model(&lidar)?;
    let beams = Beams::new(&lidar);
    let how = Use {
        skip: options.skip as usize,
        exponent: options.exponent,
        rays: options.model == Model::Beam,
    };
    match map {
        Map::Plan(world) => {
            let scan = Scan::new(lidar.fan());
            let space = FreeSpace::of_world(&world, body_radius_m);
            Ok((Sensor::of_world(&world, model, beams, scan, how), space))
        }
        Map::Cells(_) if how.rays => Err(ClientError::Usage(
            "--model beam needs walls to cast rays at, and --map has cells: use --model \
                 field"
                .to_owned(),
        )),
        Map::Cells(map) => {
            let distances = DistanceField::of_map(&map);
            let space = FreeSpace::of_map(&map, &distances, body_radius_m);
            Ok((Sensor::of_map(&map, &distances, &model, beams, how), space))
        }
    }
}
