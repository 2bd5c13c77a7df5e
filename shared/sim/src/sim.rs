//! The simulation: a configuration, commands in, frames out.
//!
//! Source: the online *Probabilistic Robotics*, chapter 4, "The simulator", whose
//! order within a tick is kept: command, motion, encoders, scan. A frame of
//! tick t shows the world at the *end* of tick t, at (t + 1)·dt.
//!
//! Departures: frames are written in place into memory the caller lends, and the
//! truth stays here, for the caller to seal, instead of going into the frame.

use nalgebra::Point2;
use rusty_contract::config::{Event, Kidnapping};
use rusty_contract::{FieldError, Frame, RunConfig};
use rusty_geometry::{Disc, SE2, Twist, World};

use crate::events::walls_after;
use crate::fleet::{Fleet, disc, driven_other};
use crate::lidar::Lidar;
use crate::noise::LidarNoise;
use crate::outcome::StepOutcome;
use crate::people::People;
use crate::robot::Robot;
use crate::scene::Scene;
use crate::script::BuiltInScript;
use crate::sensors::{Motion, SmallSensors};
use crate::sim_error::SimError;
use crate::slip::Slip;

/// A robot in a place, between two ticks.
///
/// A `Sim` is a value: a clone goes on exactly as the original does.
#[derive(Clone, Debug)]
pub struct Sim {
    config: RunConfig,
    world: World,
    robot: Robot,
    lidar: Lidar,
    /// Boxed: few runs have any, and a run without passes by.
    sensors: Option<Box<SmallSensors>>,
    script: BuiltInScript,
    slip: Slip,
    lidar_noise: LidarNoise,
    ticks_done: u64,
    /// Index of the next kidnapping of the configuration.
    next_kidnapping: usize,
    /// Index of the next event of the configuration.
    next_event: usize,
    people: People,
    /// The other robots. Boxed for the same reason as the sensors.
    fleet: Option<Box<Fleet>>,
    /// Whether anything in the world ever moves but robots.
    moves: bool,
}

impl Sim {
    /// The world of `config` before its first tick.
    ///
    /// # Errors
    /// [`SimError`] when a field cannot be used, the world is not valid, a start
    /// touches a wall, or another robot has a driver: see [`Sim::among_driven`].
    pub fn new(config: RunConfig) -> Result<Self, SimError> {
        if let Some((place, name)) = driven_other(&config) {
            let problem = format!("is \"driver\", and nothing here drives {name}");
            let remedy = "run it with `sim-server launch`, or give that robot another script";
            let field = format!("robot[{place}].script.kind");
            return Err(FieldError::new(field, "driver", problem, remedy).into());
        }
        Self::among_driven(config)
    }

    /// The same, for a caller that gives the commands of other robots' drivers before
    /// each tick, see [`Sim::drive_other`]; without one such a robot stands.
    ///
    /// # Errors
    /// [`SimError`] as of [`Sim::new`].
    pub fn among_driven(config: RunConfig) -> Result<Self, SimError> {
        config.check()?;
        let world = World::new(config.world.clone())?;
        check_places(&config, &world)?;
        let mut sim = Self {
            robot: Robot::new(&config.robot, config.start),
            lidar: Lidar::new(&config.lidar),
            sensors: SmallSensors::of(&config, &world).map(Box::new),
            fleet: Fleet::of(&config).map(Box::new),
            script: BuiltInScript::new(&config.script, config.dt_s, config.start),
            slip: Slip::new(&config.robot, &config.patches, config.robot_seed()),
            lidar_noise: LidarNoise::new(config.robot_seed()),
            ticks_done: 0,
            next_kidnapping: 0,
            next_event: 0,
            moves: config.world_moves(),
            people: People::new(&config, &world)?,
            world,
            config,
        };
        sim.look_around();
        Ok(sim)
    }

    /// Where the other robots are before the first tick.
    fn look_around(&mut self) {
        self.fleet.iter_mut().for_each(|fleet| fleet.look_around(self.people.bodies()));
    }

    /// Goes on with another configuration from the next tick on. Where the robot
    /// is, how far its wheels have turned and the number of ticks stay; noise
    /// that the change does not concern stays, too, because it depends on seed,
    /// source, tick and beam alone. With the configuration it has, nothing
    /// changes.
    ///
    /// # Errors
    /// [`SimError::Config`] when a field cannot be used, or is one that must
    /// stay as it was, see [`RunConfig::check_change`]. Then nothing changes.
    pub fn reconfigure(&mut self, config: RunConfig) -> Result<(), SimError> {
        config.check()?;
        self.config.check_change(&config)?;
        // Against the walls of the start, as where the run is simulated as a whole.
        match self.next_event {
            0 => check_places(&config, &self.world)?,
            _ => check_places(&config, &World::new(config.world.clone())?)?,
        }
        self.robot.reconfigure(&config.robot);
        self.lidar = Lidar::new(&config.lidar);
        let robot_seed = config.robot_seed();
        self.sensors.iter_mut().for_each(|sensors| sensors.reseed(robot_seed));
        self.people.reseed(config.seed);
        self.fleet.iter_mut().for_each(|fleet| fleet.reseed(&config));
        // A command depends on tick and pose, not on commands before it.
        self.script = BuiltInScript::new(&config.script, config.dt_s, config.start);
        self.slip = Slip::new(&config.robot, &config.patches, robot_seed);
        self.lidar_noise = LidarNoise::new(robot_seed);
        // Those of ticks that are done are past, or never were.
        self.next_kidnapping = config.kidnappings.partition_point(|k| k.tick < self.ticks_done);
        let past = config.events.partition_point(|event| event.tick() < self.ticks_done);
        let events_differ = self.config.events[..self.next_event] != config.events[..past];
        self.moves |= !config.events.is_empty();
        (self.config, self.next_event) = (config, past);
        if events_differ {
            self.rebuild_walls();
        }
        Ok(())
    }

    /// Back before the first tick, with another seed: the same as [`Sim::new`]
    /// with it, but what no seed has a part in (walls and their tree, beams,
    /// script) stays and is not made again. Allocates nothing where no event has
    /// changed the walls and there are no other robots. A crowd that finds no room with this seed, which
    /// [`Sim::new`] refuses, begins where it drew last.
    pub fn restart(&mut self, seed: u64) {
        self.config.seed = seed;
        self.robot = Robot::new(&self.config.robot, self.config.start);
        let robot_seed = self.config.robot_seed();
        self.slip.reseed(robot_seed);
        self.lidar_noise.restart(robot_seed);
        self.sensors.iter_mut().for_each(|sensors| sensors.restart(robot_seed));
        if self.fleet.is_some() {
            self.fleet = Fleet::of(&self.config).map(Box::new);
        }
        // The script stays: a command depends on tick and pose alone.
        self.ticks_done = 0;
        self.next_kidnapping = 0;
        if self.next_event > 0 {
            self.next_event = 0;
            self.rebuild_walls();
        }
        // A crowd that finds no room is refused when the simulation is made.
        let _ = self.people.restart(seed, &self.world, self.config.starts());
        self.look_around();
    }

    /// Makes the walls those after all events so far.
    fn rebuild_walls(&mut self) {
        let walls = walls_after(&self.config.world, &self.config.events[..self.next_event]);
        self.world = self.world.with_walls(walls);
        self.sensors.iter_mut().for_each(|sensors| sensors.walls_changed(&self.world));
    }

    /// Writes what the small sensors say at the end of a tick.
    #[inline(never)]
    fn read_sensors(&mut self, outcome: StepOutcome, tick: u64, frame: &mut Frame) {
        let motion = Motion {
            pose_in_world: self.robot.pose_in_world(),
            blocked_on_way_to: (outcome == StepOutcome::Blocked)
                .then(|| self.robot.blocked_on_way_to()),
            outcome,
        };
        let scene = Scene { world: &self.world, bodies: met(&self.fleet, &self.people) };
        if let Some(sensors) = &mut self.sensors {
            sensors.read(scene, &motion, tick, frame);
        }
    }

    /// What happens to the world at the start of the tick: events, and people's steps.
    #[inline(never)]
    fn change_world(&mut self, tick: u64) {
        let due = |event: &Event| event.tick() <= tick;
        let events = self.config.events[self.next_event..].iter();
        let now = events.take_while(|event| due(event)).count();
        if now > 0 {
            self.next_event += now;
            self.rebuild_walls();
        }
        if self.people.is_empty() {
            return;
        }
        let pose = self.robot.pose_in_world();
        match &mut self.fleet {
            Some(fleet) => self.people.step(&self.world, fleet.stand(&pose), tick),
            None => {
                let robot = disc(&pose, self.config.robot.body_radius_m);
                self.people.step(&self.world, &[robot], tick);
            }
        }
    }

    /// The motion of the own robot in a tick, between those of the robots before and after
    /// it.
    #[inline(never)]
    fn move_among_others(&mut self, applied: Twist, slip: [f64; 2], tick: u64) -> StepOutcome {
        let (world, people, dt_s) = (&self.world, self.people.bodies(), self.config.dt_s);
        let Some(fleet) = &mut self.fleet else { return StepOutcome::Blocked };
        fleet.move_before(world, people, &self.robot.pose_in_world(), tick);
        let scene = Scene { world, bodies: fleet.met() };
        let outcome = self.robot.step(scene, applied, dt_s, slip);
        fleet.move_after(world, people, &self.robot.pose_in_world(), tick);
        outcome
    }

    /// Sets the command of the driver of another robot, by its place, for the next tick:
    /// as that robot's wheels can follow it. Without one it stands.
    pub fn drive_other(&mut self, place: usize, applied: Twist) {
        self.fleet.iter_mut().for_each(|fleet| fleet.drive(place, applied));
    }

    /// A driver's command as the robot's wheels can follow it.
    #[must_use]
    pub fn limit(&self, command: Twist) -> Twist {
        self.robot.limit(command)
    }

    /// Draws the noise of the next tick's scan, if it has one: most of what a scan costs,
    /// and it depends on no command. [`step`](Self::step) does the same without it.
    pub fn prepare(&mut self) {
        if self.ticks_done.checked_rem(self.config.scan_every) == Some(0) {
            self.lidar_noise.draw(self.ticks_done, self.lidar.beams());
        }
    }

    /// One tick: takes the script's command (or `driver`'s, where the script is
    /// "driver"; `None` stands), carries the robot away where the configuration
    /// has a kidnapping, moves it, and writes tick, time, encoder
    /// counts, the command as applied (limited to what the wheels can do) and,
    /// in every `scan_every`-th tick from tick 0 on, the scan into `frame`.
    ///
    /// Allocates nothing. Does *not* seal the frame: digest and truth are the
    /// caller's to add. Goes on beyond the configured number of ticks if asked
    /// to; when to stop is the caller's to know.
    ///
    /// `driver` must be finite, and callers check that where the command comes
    /// in, because only there can the culprit be named. Builds with debug
    /// assertions stop here otherwise; others treat it as standing still.
    pub fn step(&mut self, driver: Option<Twist>, frame: &mut Frame) -> StepOutcome {
        debug_assert!(
            driver.is_none_or(|d| d.v_m_s.is_finite() && d.omega_rad_s.is_finite()),
            "driver command {driver:?} of tick {}: not finite; refuse it where it is received",
            self.ticks_done
        );
        let tick = self.ticks_done;
        if let Some(kidnapping) = self.config.kidnappings.get(self.next_kidnapping)
            && kidnapping.tick == tick
        {
            self.robot.put(kidnapping.to);
            self.next_kidnapping += 1;
        }
        if let Some(fleet) = &mut self.fleet {
            fleet.carry_away(tick);
        }
        if self.moves {
            self.change_world(tick);
        }
        let wanted = self.script.command_at(tick, &self.truth(), driver);
        let applied = self.robot.limit(wanted);
        let slip = self.slip.at(tick, &self.robot.pose_in_world());
        let outcome = if self.fleet.is_some() {
            self.move_among_others(applied, slip, tick)
        } else {
            let scene = Scene { world: &self.world, bodies: self.people.bodies() };
            self.robot.step(scene, applied, self.config.dt_s, slip)
        };

        let time_s = self.config.time_s(tick);
        frame.begin(tick, time_s, self.robot.encoder_ticks(), applied);
        if self.sensors.is_some() {
            self.read_sensors(outcome, tick, frame);
        }
        // `scan_every` 0 never divides: no scans.
        if tick.checked_rem(self.config.scan_every) == Some(0) {
            let ranges_m = frame.write_scan(self.lidar.beams());
            let pose = self.robot.pose_in_world();
            let scene = Scene { world: &self.world, bodies: met(&self.fleet, &self.people) };
            self.lidar.scan(scene, &pose, &mut self.lidar_noise, tick, ranges_m);
        }
        self.ticks_done += 1;
        outcome
    }

    /// The true pose after the last tick, world frame.
    #[must_use]
    pub fn truth(&self) -> SE2 {
        self.robot.pose_in_world()
    }

    /// How many ticks are done; also the number of the next one.
    #[must_use]
    pub fn tick(&self) -> u64 {
        self.ticks_done
    }

    /// How far the wheels have turned since the start, `[left, right]`, rad:
    /// what the encoders round.
    #[must_use]
    pub fn wheel_angles_rad(&self) -> [f64; 2] {
        self.robot.wheel_angles_rad()
    }

    /// People and other robots as they are now: what the robot and its sensors meet.
    #[must_use]
    pub fn bodies(&self) -> &[Disc] {
        met(&self.fleet, &self.people)
    }

    /// The walls, as they are now.
    #[must_use]
    pub fn world(&self) -> &World {
        &self.world
    }

    /// The configuration, as it was given last.
    #[must_use]
    pub fn config(&self) -> &RunConfig {
        &self.config
    }
}

/// What the robot and its sensors meet but walls.
fn met<'a>(fleet: &'a Option<Box<Fleet>>, people: &'a People) -> &'a [Disc] {
    fleet.as_ref().map_or(people.bodies(), |fleet| fleet.met())
}

/// Checks every place where the robot is put: the start, and kidnappings.
fn check_places(config: &RunConfig, world: &World) -> Result<(), SimError> {
    let radius_m = config.robot.body_radius_m;
    check_place("start", &config.start, radius_m, world)?;
    check_kidnappings("", &config.kidnappings, radius_m, config, world)?;
    for (place, other) in config.fleet.iter().flat_map(|fleet| fleet.others()) {
        let (field, radius_m) = (format!("robot[{place}]."), other.robot.body_radius_m);
        check_place(&format!("{field}start"), &other.start, radius_m, world)?;
        check_kidnappings(&field, &other.kidnappings, radius_m, config, world)?;
    }
    Ok(())
}

/// Checks where a robot is carried, among the walls of that tick.
fn check_kidnappings(
    prefix: &str,
    list: &[Kidnapping],
    body_radius_m: f64,
    config: &RunConfig,
    at_start: &World,
) -> Result<(), SimError> {
    let (mut events, mut changed) = (0, None);
    for (i, kidnapping) in list.iter().enumerate() {
        let past = config.events.partition_point(|event| event.tick() <= kidnapping.tick);
        if past != events {
            let walls = walls_after(&config.world, &config.events[..past]);
            (events, changed) = (past, Some(at_start.with_walls(walls)));
        }
        let field = format!("{prefix}kidnapping[{i}].to");
        let world = changed.as_ref().unwrap_or(at_start);
        check_place(&field, &kidnapping.to, body_radius_m, world)?;
    }
    Ok(())
}

/// Checks that a place is inside the world, and that the body touches no wall
/// there: every step of one that does is blocked.
fn check_place(
    field: &str,
    place: &SE2,
    body_radius_m: f64,
    world: &World,
) -> Result<(), SimError> {
    if world.blocks(place, place, body_radius_m) {
        let distance_m = world.distance_to_nearest(Point2::from(place.translation()));
        return Err(SimError::StartInWall {
            field: field.to_owned(),
            world: world.name().to_owned(),
            x_m: place.x(),
            y_m: place.y(),
            body_radius_m,
            distance_m,
            missing_m: body_radius_m - distance_m,
        });
    }
    let [x_min, y_min, x_max, y_max] = world.spec().bounds;
    if !((x_min..=x_max).contains(&place.x()) && (y_min..=y_max).contains(&place.y())) {
        let value = format!("({}, {}) m", place.x(), place.y());
        let problem = format!("lies outside the world {:?}", world.name());
        let remedy = format!("put it within x {x_min} to {x_max} m, y {y_min} to {y_max} m");
        return Err(FieldError::new(field, value, problem, remedy).into());
    }
    Ok(())
}
