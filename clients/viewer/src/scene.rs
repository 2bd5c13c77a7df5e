//! What a page is told in JSON: the scene once, the state whenever it changes; and what
//! it asks for.

use rusty_contract::config::sensors::BumperConfig;
use rusty_contract::{LogHeader, Role, Start};
use rusty_geometry::{Material, SE2, WorldSpec};
use rusty_plot::style::Look;
use serde::{Deserialize, Serialize};

/// Where the ticks come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Mode {
    /// A run that goes on.
    Run,
    /// A log.
    Log,
}

/// What does not change during a run.
#[derive(Clone, Debug, Serialize)]
pub struct Scene {
    message: &'static str,
    mode: Mode,
    scenario: String,
    /// As text: a number of JavaScript has 53 bits.
    seed: Option<String>,
    ticks: u64,
    dt_s: f64,
    /// Whether true poses, errors and answers are shown.
    truth: bool,
    bounds_m: [f64; 4],
    walls: Vec<(f64, f64, f64, f64, &'static str)>,
    /// Ticks at whose start the robot is put elsewhere.
    kidnapped_at: Vec<u64>,
    body_radius_m: f64,
    wheel_limit_m_s: f64,
    track_m: f64,
    beams: u32,
    first_bearing_rad: f64,
    fov_rad: f64,
    range_max_m: f64,
    sensor_in_body: [f64; 3],
    bumper: Option<BumperConfig>,
    sonar: Option<Sonar>,
    estimators: Vec<Named>,
    /// Of a whole log, 32 hexadecimal digits.
    digest: Option<String>,
    /// For people: what is not shown, or how the run ended.
    remark: Option<String>,
}

/// The geometry of the sonars.
#[derive(Clone, Debug, Serialize)]
struct Sonar {
    /// x, y and axis of each, body frame, m and rad.
    mounts: Vec<[f64; 3]>,
    aperture_rad: f64,
    range_max_m: f64,
}

#[derive(Clone, Debug, Serialize)]
struct Named {
    name: String,
    is_driver: bool,
    /// Colours on light and on dark ground.
    colours: [String; 2],
    width: f64,
}

impl Scene {
    /// The scene of a run or log with this header.
    #[must_use]
    pub fn of(header: &LogHeader, mode: Mode) -> Self {
        let config = &header.config;
        let count = header.answering().count();
        let named = |(i, p): (usize, &rusty_contract::Participant)| {
            let look = Look::of(i, count);
            Named {
                name: p.name.clone(),
                is_driver: p.role == Role::Driver,
                colours: look.inks().map(|ink| ink.to_string()),
                width: look.width,
            }
        };
        let seed = header.seed();
        let robot = config.fleet.as_ref().map(|fleet| format!(", robot {}", fleet.name));
        let viewer = rusty_contract::Participant::new("view", Role::Estimator);
        let of_start = Self::of_start(&Start::new(header, 0, &viewer), mode);
        let hidden = header.is_blind() && header.known_world().is_none();
        Self {
            scenario: config.scenario.clone() + &robot.unwrap_or_default(),
            seed: seed.map(|seed| seed.to_string()),
            truth: true,
            bounds_m: if hidden { of_start.bounds_m } else { config.world.bounds },
            walls: walls(&config.world),
            kidnapped_at: header.kidnappings().map(|k| k.tick).collect(),
            estimators: header.answering().enumerate().map(named).collect(),
            ..of_start
        }
    }

    /// The scene with a remark for people.
    #[must_use]
    pub fn with_remark(self, remark: Option<String>) -> Self {
        Self { remark: remark.or(self.remark), ..self }
    }

    /// The scene of a log with this run digest.
    #[must_use]
    pub fn with_digest(self, digest: Option<String>) -> Self {
        Self { digest, ..self }
    }

    /// The scene of a run of which an observer without the key knows.
    #[must_use]
    pub fn of_start(start: &Start, mode: Mode) -> Self {
        let (lidar, robot) = (&start.lidar, &start.robot);
        let reach_m = lidar.range_max_m;
        let at = &lidar.sensor_in_body;
        Self {
            message: "scene",
            mode,
            scenario: start.scenario.clone(),
            seed: None,
            ticks: start.ticks,
            dt_s: start.dt_s,
            truth: false,
            bounds_m: [-reach_m, -reach_m, reach_m, reach_m],
            walls: Vec::new(),
            kidnapped_at: Vec::new(),
            body_radius_m: robot.body_radius_m,
            wheel_limit_m_s: robot.wheel_limit_rad_s * robot.drive.wheel_radius_m,
            track_m: robot.drive.track_m,
            beams: lidar.beams,
            first_bearing_rad: lidar.first_bearing_rad,
            fov_rad: lidar.fov_rad,
            range_max_m: lidar.range_max_m,
            sensor_in_body: pose(at),
            bumper: start.sensors.bumper,
            sonar: start.sensors.sonar.as_ref().map(|sonar| Sonar {
                mounts: sonar.mounts.iter().map(pose).collect(),
                aperture_rad: sonar.aperture_rad,
                range_max_m: sonar.range_max_m,
            }),
            estimators: Vec::new(),
            digest: None,
            remark: None,
        }
    }
}

fn pose(pose: &SE2) -> [f64; 3] {
    [pose.x(), pose.y(), pose.theta()]
}

fn walls(world: &WorldSpec) -> Vec<(f64, f64, f64, f64, &'static str)> {
    let wall = |w: &rusty_geometry::WallSpec| {
        let material = match w.material {
            Material::Wall => "wall",
            Material::Glass => "glass",
            Material::Door(_) => "door",
        };
        (w.a[0], w.a[1], w.b[0], w.b[1], material)
    };
    world.walls.iter().map(wall).collect()
}

/// What changes now and then.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Status {
    message: &'static str,
    /// `waiting`, `running`, `paused` or `ended`.
    pub state: &'static str,
    /// Simulated seconds per second; `None`: as fast as everyone answers.
    pub pace: Option<f64>,
    /// A sentence for people.
    pub text: String,
}

impl Status {
    /// A state with its sentence.
    #[must_use]
    pub fn new(state: &'static str, pace: Option<f64>, text: impl Into<String>) -> Self {
        Self { message: "status", state, pace, text: text.into() }
    }
}

/// What a page asks for.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(tag = "do", rename_all = "lowercase", deny_unknown_fields)]
pub enum PageRequest {
    /// No tick after the one that is being worked on.
    Pause,
    /// On, at the pace it had.
    Resume,
    /// A number of ticks, then pause.
    Step {
        /// How many.
        ticks: u64,
    },
    /// Another pace: simulated seconds per second, or as fast as possible.
    Pace {
        /// The factor.
        factor: Option<f64>,
    },
    /// Another tick of a log.
    Seek {
        /// Which.
        tick: u64,
    },
    /// A command for the robot, as parts of what it can do: ahead and to the left, -1 to 1.
    Drive {
        /// Part of the greatest speed.
        ahead: f64,
        /// Part of the greatest turn rate.
        left: f64,
    },
}
