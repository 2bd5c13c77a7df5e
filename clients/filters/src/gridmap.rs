//! Mapping as a participant: scans and poses in, a map out.
//!
//! The mapping itself is [`crate::occupancy_grid`]. Here is where the poses come
//! from ([`Poses`]): its own, with which it maps like any estimator, live as on a
//! log; or those of a participant that a log holds, which only one who may read the truth of
//! a run is shown. A map from true poses is no result of a robot: it says what
//! the model and the laser are good for when nothing else is wrong. On a recorded
//! log the truth is a corrected trajectory, and its map is what others localise
//! in.

use std::path::{Path, PathBuf};

use clap::Args;
use rusty_clients::recorder::{Ending, Step};
use rusty_clients::{ClientArgs, ClientError, Filter, Recorder, Tick};
use rusty_contract::{Brief, Exit, Reply, Start, errln, replace};
use rusty_geometry::SE2;

use crate::beams::believed_lidar;
use crate::map_picture::svg;
use crate::moment::{Moment, RunClock};
use crate::occupancy_grid::{GridError, InverseModel};
use crate::tangent::estimate;
use crate::{Beams, OccupancyGrid, Odometry, OdometryNoise};
use rusty_floorplan::map_server::beside;

/// Where the poses come from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Poses {
    /// The wheels alone.
    Odometry,
    /// The truth of a run or log.
    Truth,
    /// What this participant answered.
    Of(String),
}

impl std::str::FromStr for Poses {
    type Err = std::convert::Infallible;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Ok(match text {
            "odometry" => Self::Odometry,
            "truth" => Self::Truth,
            name => Self::Of(name.to_owned()),
        })
    }
}

/// Build an occupancy grid from scans and poses
///
/// The map is written at the end. Each beam marks the cells that it crosses as free
/// and its last cell as occupied; each cell sums the log odds. The poses must be
/// right: a heading error of one degree doubles a wall at 5 m, 9 cm apart.
///
/// With --poses odometry, gridmap is an ordinary estimator, in a run or on a log: it
/// maps with the poses of its odometry, which drift, and answers them. --poses NAME
/// maps with the estimates of another filter. --poses truth shows the best possible
/// map, which no robot can have. These two need access to the truth: a log (with
/// --key-file if it is blind), or in a run the role of a scorer.
///
/// The noise of the wheels (--alpha1 to --alpha4) does not change the map. It sets the
/// covariance of the answers with --poses odometry and has no other effect.
///
///   gridmap --log run.log --poses mcl --save map
///   gridmap --log intel.log --poses truth --until 1326 --save intel
#[derive(Args, Clone, Debug)]
#[command(verbatim_doc_comment)]
pub struct Options {
    /// Source of the poses, odometry, truth or a participant
    #[arg(long, value_name = "WHOSE", default_value = "odometry")]
    pub poses: Poses,

    /// Save the map as STEM.pgm, STEM.yaml and STEM.png
    #[arg(long, value_name = "STEM")]
    pub save: PathBuf,

    /// Start of mapping after the start of the run, s or ticks (12.5, 400ticks)
    #[arg(long, value_name = "MOMENT", default_value = "0")]
    pub from: Moment,

    /// End of mapping after the start of the run, s or ticks
    #[arg(long, value_name = "MOMENT")]
    pub until: Option<Moment>,

    /// What is believed of a reading
    #[command(flatten)]
    pub model: InverseModel,

    /// The wheels.
    #[command(flatten)]
    pub noise: OdometryNoise,
}

/// Collects scans into a grid, and writes it down.
#[derive(Debug)]
pub struct Mapper {
    options: Options,
    beams: Beams,
    grid: OccupancyGrid,
    clock: RunClock,
    dt_s: f64,
    path: Vec<[f64; 2]>,
    without_pose: u64,
}

/// Checks that a map `stem` names files, and replaces none unasked.
///
/// # Errors
/// [`ClientError::InTheWay`] names the first of its files that is there,
/// [`ClientError::Usage`] a stem that is a folder.
pub fn check_free(args: &ClientArgs, stem: &Path) -> Result<(), ClientError> {
    if stem.file_name().is_none() || stem.as_os_str().as_encoded_bytes().ends_with(b"/.") {
        let text = format!("{} is a folder: give a name for the map in it", stem.display());
        return Err(ClientError::Usage(text));
    }
    [".pgm", ".yaml", ".png"].iter().try_for_each(|end| args.check_free(&beside(stem, end)))
}

impl Mapper {
    /// Begins with nothing known.
    pub fn new(start: &Start, options: &Options) -> Self {
        Self {
            options: options.clone(),
            beams: Beams::new(&believed_lidar(start)),
            grid: OccupancyGrid::new(options.model),
            clock: RunClock::default(),
            dt_s: start.dt_s,
            path: Vec::new(),
            without_pose: 0,
        }
    }

    /// Takes a tick: the scan, if there was one, from this pose, if it is known.
    ///
    /// # Errors
    /// A pose so far off that the grid would be too large.
    pub fn tick(
        &mut self,
        time_s: f64,
        ranges_m: Option<&[f64]>,
        pose: Option<SE2>,
    ) -> Result<(), ClientError> {
        let Options { from, until, .. } = self.options;
        let now = self.clock.tick(time_s, self.dt_s);
        let is_wanted = now.is_from(from) && until.is_none_or(|until| now.is_until(until));
        let Some(ranges_m) = ranges_m.filter(|_| is_wanted) else { return Ok(()) };
        let Some(pose) = pose else {
            self.without_pose += 1;
            return Ok(());
        };
        let at = |e| ClientError::Unusable(format!("{:.2} s: {e}", now.s));
        self.add(ranges_m, &pose).map_err(at)
    }

    /// Takes in a scan from a pose, whatever the time.
    ///
    /// # Errors
    /// A pose so far off that the grid would be too large.
    pub fn add(&mut self, ranges_m: &[f64], pose: &SE2) -> Result<(), GridError> {
        self.grid.add(pose, ranges_m, &self.beams)?;
        self.path.push([pose.x(), pose.y()]);
        Ok(())
    }

    /// Writes map and picture, and says what is in them.
    ///
    /// # Errors
    /// No scan had a pose, or a file cannot be written.
    pub fn finish(self) -> Result<String, ClientError> {
        let (scans, without) = (self.grid.scans(), self.without_pose);
        let nothing = || {
            ClientError::Unusable(format!(
                "nothing to map: {scans} scans had a pose and {without} had none; choose other \
                 --poses, or other times with --from and --until"
            ))
        };
        self.write()?.ok_or_else(nothing)
    }

    /// Writes map and picture, and says what is in them; `None`, and no file, where
    /// nothing is known.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn write(self) -> Result<Option<String>, ClientError> {
        let Some(known) = self.grid.known() else { return Ok(None) };
        let (scans, stem) = (self.grid.scans(), &self.options.save);
        let map = self.grid.to_map();
        map.save(stem)?;
        let title = stem.file_name().unwrap_or_default().to_string_lossy();
        let title = format!("{title}: {scans} scans in cells of {} m", map.frame.cell_m);
        let png = rusty_plot::png(&svg(&self.grid, known, &title, &self.path))
            .map_err(|e| ClientError::Picture(e.to_string()))?;
        let file = beside(stem, ".png");
        replace(&file, &png).map_err(ClientError::io(&file))?;
        let frame = map.frame;
        let metres = |cells: usize| cells as f64 * frame.cell_m;
        let share = |wanted| {
            let count = map.cells.iter().filter(|cell| **cell == wanted).count();
            100.0 * count as f64 / map.cells.len() as f64
        };
        Ok(Some(format!(
            "{scans} scans ({} left out: no pose) on {} × {} cells, {:.1} m × {:.1} m: {:.1} % \
             free, {:.1} % occupied; {stem}.pgm, .yaml and .png",
            self.without_pose,
            frame.width,
            frame.height,
            metres(frame.width),
            metres(frame.height),
            share(crate::Cell::Free),
            share(crate::Cell::Occupied),
            stem = stem.display(),
        )))
    }
}

/// Maps with the poses of the wheels, and answers them.
pub struct GridMap {
    mapper: Mapper,
    odometry: Odometry,
    start_in_world: SE2,
    /// Why it maps no more.
    problem: Option<ClientError>,
}

impl GridMap {
    /// Begins where it is told that the robot starts, or in the world's origin.
    pub fn new(start: &Start, options: &Options) -> Self {
        Self {
            mapper: Mapper::new(start, options),
            odometry: Odometry::new(start.robot.drive, options.noise),
            start_in_world: start.initial_pose.unwrap_or_default(),
            problem: None,
        }
    }
}

impl Filter for GridMap {
    fn update(&mut self, tick: &Tick<'_>) -> Reply {
        let motion = *self.odometry.advance(tick.encoders());
        let pose = self.start_in_world.compose(&motion.now_in_then);
        if self.problem.is_none() {
            self.problem = self.mapper.tick(tick.time_s(), tick.ranges_m(), Some(pose)).err();
        }
        estimate(&pose, &motion.covariance).into()
    }

    fn finish(self) -> Result<(), ClientError> {
        // A run that ended before it began is the failure of another process.
        if !self.mapper.clock.is_running() {
            return Ok(());
        }
        // What was mapped before is written all the same.
        let written = self.mapper.finish();
        if let Some(problem) = self.problem {
            return Err(problem);
        }
        errln!("{}", written?);
        Ok(())
    }
}

/// Maps with poses that only one who may read the truth is shown.
pub struct GridMapOf {
    mapper: Mapper,
    /// Whose answers, by place; `None`: the truth.
    place: Option<usize>,
}

impl GridMapOf {
    /// Begins with the poses of `options`.
    ///
    /// # Errors
    /// No participant of that name answered, the log is blind, or the poses are the wheels'
    /// own, which are [`GridMap`]'s business.
    pub fn new(start: &Start, brief: &Brief, options: &Options) -> Result<Self, ClientError> {
        let names = || brief.header.answering().map(|p| p.name.as_str());
        let place = match &options.poses {
            Poses::Of(name) => Some(names().position(|n| n == name).ok_or_else(|| {
                let there: Vec<&str> = names().collect();
                ClientError::Usage(format!(
                    "--poses {name}: nobody of that name answered in this run; there are odometry, \
                     truth, {}",
                    there.join(", ")
                ))
            })?),
            Poses::Truth => None,
            Poses::Odometry => {
                let text = "--poses odometry: who maps with the wheels' poses is an estimator";
                return Err(ClientError::Usage(text.to_owned()));
            }
        };
        if place.is_none() && brief.header.is_blind() {
            let text = "--poses truth: the log is blind and has none; give its --key-file";
            return Err(ClientError::Unusable(text.to_owned()));
        }
        Ok(Self { mapper: Mapper::new(start, options), place })
    }
}

impl Recorder for GridMapOf {
    fn step(&mut self, step: &Step<'_>) -> Result<(), ClientError> {
        let pose = match self.place {
            None => step.truth,
            Some(place) => {
                step.replies.get(place).and_then(Reply::estimate).map(|e| e.pose_in_world)
            }
        };
        self.mapper.tick(step.frame.time_s(), step.frame.ranges_m(), pose)
    }

    fn finish(self, ending: Ending) -> Result<Exit, ClientError> {
        errln!("{}", self.mapper.finish()?);
        Ok(ending.exit())
    }
}
