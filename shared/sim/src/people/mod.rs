//! People: bodies that move among the walls.
//!
//! Walkers follow their waypoints, a crowd walks by social forces (see `force`) towards
//! goals drawn from the seed. The LiDAR sees them, the robot is stopped by them, and a
//! person who would touch the robot waits.
//!
//! The forces are computed once in 0.1 s of simulated time, in between each
//! person keeps their velocity. Every draw is a function of seed, person and count, so
//! a person more changes no number that another draws.

mod force;
mod gait;

use core::cell::Cell;

use nalgebra::{Point2, Vector2};
use rusty_contract::config::{CrowdConfig, FieldError, Shape, WalkerConfig};
use rusty_contract::{RunConfig, config::MAX_PEOPLE};
use rusty_geometry::{Disc, SE2, World};

use self::force::{Other, away_from, away_from_wall, drive, length};
use self::gait::Gait;
use crate::noise::PeopleNoise;

/// Time from one decision of a crowd to the next, s.
const DECIDE_S: f64 = 0.1;
/// How near a person comes to a goal before they choose the next, m.
const ARRIVED_M: f64 = 0.3;
/// Without a step towards it, a goal is given up after this time, s.
const PATIENCE_S: f64 = 5.0;
/// The fastest that a person walks, as a multiple of the speed they like.
const FASTEST: f64 = 1.3;
/// The least distance that a person keeps from the robot's body, m.
const ROBOT_GAP_M: f64 = 0.02;
/// How often a place is drawn before the world counts as full.
const TRIES: u32 = 10_000;
/// How far from a wall its force is felt, m.
const WALL_REACH_M: f64 = 1.5;

/// A person.
#[derive(Clone, Debug)]
struct Person {
    at: Point2<f64>,
    velocity_m_s: Vector2<f64>,
    likes_m_s: f64,
    radius_m: f64,
    goal: Point2<f64>,
    /// Waypoints still ahead of a walker: index of the goal.
    waypoint: usize,
    /// How many numbers this person has drawn.
    drawn: u64,
    /// Nearest to the goal so far, m, and the time since then, s.
    nearest_m: f64,
    waited_s: f64,
    /// No wall is nearer than this, m.
    clear_m: f64,
    gait: Gait,
}

/// All people of a run.
#[derive(Clone, Debug)]
pub struct People {
    walkers: Vec<WalkerConfig>,
    crowd: CrowdConfig,
    /// Walkers first, then the crowd.
    people: Vec<Person>,
    /// What the LiDAR sees and the robot touches.
    bodies: Vec<Disc>,
    noise: PeopleNoise,
    dt_s: f64,
    /// A decision in one of N ticks.
    decide_every: u64,
}

impl People {
    /// The people of `config` before the first tick.
    ///
    /// # Errors
    /// [`FieldError`] if a crowd finds no room in `world`.
    pub fn new(config: &RunConfig, world: &World) -> Result<Self, FieldError> {
        let crowd = config.crowd.unwrap_or(CrowdConfig { people: 0, ..CrowdConfig::default() });
        let count = config.walkers.len() + crowd.people as usize;
        let mut people = Self {
            walkers: config.walkers.clone(),
            crowd,
            people: Vec::with_capacity(count.min(2 * MAX_PEOPLE)),
            bodies: Vec::with_capacity(2 * count),
            noise: PeopleNoise::new(config.seed),
            dt_s: config.dt_s,
            decide_every: ((DECIDE_S / config.dt_s) as u64).max(1),
        };
        let homeless = people.restart(config.seed, world, config.starts());
        if homeless > 0 {
            let problem = format!("{homeless} found no room in {TRIES} tries each");
            let remedy = "lower crowd.people or crowd.radius_m, or take a larger world";
            return Err(FieldError::new("crowd.people", people.crowd.people, problem, remedy));
        }
        Ok(people)
    }

    /// Back before the first tick, with another seed. Returns how many of the crowd
    /// found no room; they start where they drew last.
    pub fn restart(
        &mut self,
        seed: u64,
        world: &World,
        robots: impl Iterator<Item = SE2> + Clone,
    ) -> usize {
        self.noise = PeopleNoise::new(seed);
        self.people.clear();
        for walker in &self.walkers {
            let at = Point2::from(walker.waypoints[0]);
            let mut person = Person::new(at, walker.speed_m_s, walker.radius_m);
            person.waypoint = 1 % walker.waypoints.len();
            person.goal = Point2::from(walker.waypoints[person.waypoint]);
            self.people.push(person);
        }
        let found = (0..self.crowd.people).map(|_| self.add_to_crowd(world, robots.clone()));
        let homeless = found.filter(|found| !found).count();
        self.show();
        homeless
    }

    /// Goes on with the noise of another seed; where people are and where they go
    /// stays until they choose their next goals.
    pub fn reseed(&mut self, seed: u64) {
        self.noise = PeopleNoise::new(seed);
    }

    /// Whether the run has no people.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.people.is_empty()
    }

    /// What a sensor sees of them and a robot touches, world frame.
    #[must_use]
    pub fn bodies(&self) -> &[Disc] {
        &self.bodies
    }

    fn add_to_crowd(&mut self, world: &World, robots: impl Iterator<Item = SE2> + Clone) -> bool {
        let (index, radius_m) = (self.people.len(), self.crowd.radius_m);
        let mut person = Person::new(Point2::origin(), 0.0, radius_m);
        // Walkers draw nothing: one more of them changes no number of the crowd.
        let row = index - self.walkers.len();
        let z = self.noise.normal(row, &mut person.drawn);
        person.likes_m_s = (self.crowd.speed_m_s + self.crowd.speed_std_m_s * z).max(0.0);
        let starts = robots.map(|robot| Point2::from(robot.translation()));
        let is_free = |people: &[Person], at: Point2<f64>| {
            world.distance_to_nearest(at) > radius_m + 0.1
                && starts.clone().all(|robot| length(&(at - robot)) > radius_m + 1.0)
                && people.iter().all(|p| length(&(p.at - at)) > p.radius_m + radius_m)
        };
        let found = (0..TRIES).any(|_| {
            person.at = self.noise.place(row, &mut person.drawn, world.bounds());
            is_free(&self.people, person.at)
        });
        self.people.push(person);
        self.choose_goal(index, world);
        found
    }

    /// A goal that one can walk to straight on, if one is found soon; else any.
    fn choose_goal(&mut self, index: usize, world: &World) {
        let (row, person) = (index - self.walkers.len(), &mut self.people[index]);
        for _ in 0..100 {
            person.goal = self.noise.place(row, &mut person.drawn, world.bounds());
            let to = person.goal - person.at;
            let distance_m = length(&to);
            let clear = world.distance_to_nearest(person.goal) > person.radius_m + 0.2
                && distance_m > 1.0
                && world.first_wall(person.at, to / distance_m, distance_m).is_none();
            if clear {
                break;
            }
        }
        (person.nearest_m, person.waited_s) = (f64::INFINITY, 0.0);
    }

    /// One tick: everybody walks. `robots` are the bodies of robots, in the
    /// order of their places.
    /// Allocates nothing.
    pub fn step(&mut self, world: &World, robots: &[Disc], tick: u64) {
        let decides = tick.is_multiple_of(self.decide_every);
        for index in 0..self.people.len() {
            if index < self.walkers.len() {
                let waypoint = self.follow(index);
                if self.walk(index, world, robots) {
                    self.go_to(index, waypoint);
                }
                continue;
            }
            if decides {
                self.decide(index, world, robots);
            }
            self.walk(index, world, robots);
        }
        self.show();
    }

    /// The velocity of a walker in this step. Returns its waypoint at the end: a step
    /// goes on past a waypoint, for all of its length.
    fn follow(&mut self, index: usize) -> usize {
        let (walker, person) = (&self.walkers[index], &mut self.people[index]);
        let to = person.goal - person.at;
        let (distance_m, step_m) = (length(&to), walker.speed_m_s * self.dt_s);
        if distance_m > step_m {
            person.velocity_m_s = to * (walker.speed_m_s / distance_m);
            return person.waypoint;
        }
        let (mut at, mut waypoint, mut left_m) =
            (person.goal, person.waypoint, step_m - distance_m);
        // Once round at most: a way of no length has no end.
        for _ in 0..walker.waypoints.len() {
            waypoint = (waypoint + 1) % walker.waypoints.len();
            let goal = Point2::from(walker.waypoints[waypoint]);
            let distance_m = length(&(goal - at));
            if distance_m > left_m {
                at += (goal - at) * (left_m / distance_m);
                break;
            }
            (at, left_m) = (goal, left_m - distance_m);
        }
        person.velocity_m_s = (at - person.at) / self.dt_s;
        waypoint
    }

    fn go_to(&mut self, index: usize, waypoint: usize) {
        let (walker, person) = (&self.walkers[index], &mut self.people[index]);
        (person.waypoint, person.goal) = (waypoint, Point2::from(walker.waypoints[waypoint]));
    }

    /// The velocity of one of the crowd until the next decision.
    fn decide(&mut self, index: usize, world: &World, robots: &[Disc]) {
        let decision_s = self.decide_every as f64 * self.dt_s;
        let person = &mut self.people[index];
        let distance_m = length(&(person.goal - person.at));
        if distance_m < person.nearest_m - 0.05 {
            (person.nearest_m, person.waited_s) = (distance_m, 0.0);
        } else {
            person.waited_s += decision_s;
        }
        if distance_m < ARRIVED_M || person.waited_s > PATIENCE_S {
            self.choose_goal(index, world);
        }
        let person = &self.people[index];
        let to = person.goal - person.at;
        let liked = to / length(&to).max(1e-9);
        let mut force = drive(liked * person.likes_m_s, person.velocity_m_s);
        for (k, p) in self.people.iter().enumerate() {
            if k != index {
                let other = Other { at: p.at, velocity_m_s: p.velocity_m_s };
                force += away_from(person.at, liked, &other);
            }
        }
        if self.crowd.avoids_robot {
            for robot in robots {
                let other = Other { at: robot.centre, velocity_m_s: Vector2::zeros() };
                force += away_from(person.at, liked, &other);
            }
        }
        let wall = nearest_point(world, person.at);
        force += wall.map_or_else(Vector2::zeros, |wall| away_from_wall(person.at, wall));
        let clear_m = wall.map_or(WALL_REACH_M, |wall| length(&(person.at - wall)));
        let wished = person.velocity_m_s + force * decision_s;
        let (speed, most) = (length(&wished), FASTEST * person.likes_m_s);
        let velocity = if speed > most { wished * (most / speed) } else { wished };
        let person = &mut self.people[index];
        (person.velocity_m_s, person.clear_m) = (velocity, clear_m);
    }

    /// A step with the velocity that there is, unless something is in the way. Returns
    /// whether it was made.
    fn walk(&mut self, index: usize, world: &World, robots: &[Disc]) -> bool {
        let (dt_s, is_walker, shape) = (self.dt_s, index < self.walkers.len(), self.shape(index));
        let person = &mut self.people[index];
        let way = person.velocity_m_s * dt_s;
        let (next, way_m) = (person.at + way, length(&way));
        let pose = |at: Point2<f64>| SE2::new(at.x, at.y, 0.0);
        let reach_m = match shape {
            Shape::Disc => person.radius_m,
            Shape::Legs => person.radius_m.max(gait::REACH_M),
        };
        let meets_robot = robots.iter().any(|robot| {
            let keep = Disc { radius_m: robot.radius_m + ROBOT_GAP_M, ..*robot };
            way.dot(&(robot.centre - person.at)) > 0.0
                && keep.blocks(&pose(person.at), &pose(next), reach_m)
        });
        person.clear_m -= way_m;
        // Who is too near a wall may walk away from it.
        let meets_wall = !is_walker
            && person.clear_m <= 0.5 * person.radius_m
            && world.blocks(&pose(person.at), &pose(next), 0.5 * person.radius_m)
            && (world.distance_to_nearest(next) <= world.distance_to_nearest(person.at)
                || world.first_wall(person.at, way / way_m, way_m).is_some());
        if meets_robot || meets_wall {
            person.velocity_m_s = Vector2::zeros();
            person.gait.stand();
            return false;
        }
        person.gait.walk(&person.velocity_m_s, dt_s);
        person.at = next;
        true
    }

    fn shape(&self, index: usize) -> Shape {
        self.walkers.get(index).map_or(self.crowd.shape, |walker| walker.shape)
    }

    /// Puts the bodies where their people are.
    fn show(&mut self) {
        self.bodies.clear();
        for (index, person) in self.people.iter().enumerate() {
            match self.shape(index) {
                Shape::Disc => {
                    self.bodies.push(Disc { centre: person.at, radius_m: person.radius_m });
                }
                Shape::Legs => self.bodies.extend(person.gait.legs(person.at)),
            }
        }
    }
}

impl Person {
    fn new(at: Point2<f64>, likes_m_s: f64, radius_m: f64) -> Self {
        Self {
            at,
            velocity_m_s: Vector2::zeros(),
            likes_m_s,
            radius_m,
            goal: at,
            waypoint: 0,
            drawn: 0,
            nearest_m: f64::INFINITY,
            waited_s: 0.0,
            clear_m: 0.0,
            gait: Gait::default(),
        }
    }
}

/// The nearest point of any wall within reach of its force.
fn nearest_point(world: &World, at: Point2<f64>) -> Option<Point2<f64>> {
    let nearest = Cell::new((WALL_REACH_M * WALL_REACH_M, None));
    let _ = world.least_squared(at, WALL_REACH_M * WALL_REACH_M, |wall| {
        let square = wall.distance_squared(&at);
        if square < nearest.get().0 {
            nearest.set((square, Some(wall.nearest(&at))));
        }
        Some(square)
    });
    nearest.get().1
}

#[cfg(test)]
mod tests;
