//! The configuration of a run from text: a line `key=value` for each field of a scenario.
//!
//! Keys are those of `--set`; an element of a list has its index as a part of the key
//! (`kidnapping.0.tick`). The floor plan is under `floor`. A parser of TOML or JSON would
//! be a third of the module. A field that is not read here is an error, so that no run is
//! another one than its scenario says.

use std::str::FromStr;

use rusty_contract::config::{Kidnapping, LidarConfig, PatrolConfig};
use rusty_contract::scenario::Access;
use rusty_contract::{DataSheet, Participant, RobotConfig, Role, RunConfig, ScriptConfig, Sensors};
use rusty_geometry::{Material, SE2, Twist, WallSpec, WorldSpec};

/// Fields by key; those that are read are taken out.
struct Fields<'a>(Vec<(&'a str, &'a str)>);

impl<'a> Fields<'a> {
    fn text(&mut self, key: &str) -> Option<&'a str> {
        let at = self.0.iter().position(|(name, _)| *name == key)?;
        Some(self.0.swap_remove(at).1)
    }

    /// The value at `key`; without one `usual`.
    fn value<T: FromStr>(&mut self, key: &str, usual: T) -> Result<T, String> {
        let Some(text) = self.text(key) else { return Ok(usual) };
        text.parse().map_err(|_| format!("{key}={text}: expected a number; change the value"))
    }

    fn set(&mut self, key: &str, value: &mut f64) -> Result<(), String> {
        *value = self.value(key, *value)?;
        Ok(())
    }

    fn pose(&mut self, key: &str, usual: SE2) -> Result<SE2, String> {
        let x_m = self.value(&format!("{key}.x_m"), usual.x())?;
        let y_m = self.value(&format!("{key}.y_m"), usual.y())?;
        Ok(SE2::new(x_m, y_m, self.value(&format!("{key}.theta_rad"), usual.theta())?))
    }

    /// The elements of the list at `key`, which `read` has until there is none.
    fn list<T>(
        &mut self,
        key: &str,
        mut read: impl FnMut(&mut Self, &str) -> Result<Option<T>, String>,
    ) -> Result<Vec<T>, String> {
        let mut list = Vec::new();
        while let Some(element) = read(self, &format!("{key}.{}", list.len()))? {
            list.push(element);
        }
        Ok(list)
    }

    /// Whether there is a field at `key`, for the first of each element of a list.
    fn has(&self, key: &str) -> bool {
        self.0.iter().any(|(name, _)| *name == key)
    }
}

/// Reads the configuration and the roster of a run.
///
/// # Errors
/// A sentence that names the field that cannot be used.
pub fn read(text: &str, seed: u64) -> Result<(RunConfig, Vec<Participant>), String> {
    let lines = text.lines().filter_map(|line| line.split_once('='));
    let mut fields = Fields(lines.collect());
    let mut robot = RobotConfig::default();
    fields.set("robot.slip_std", &mut robot.slip_std)?;
    fields.set("robot.radius_bias_right", &mut robot.radius_bias_right)?;
    let mut lidar = LidarConfig::default();
    lidar.beams = fields.value("lidar.beams", lidar.beams)?;
    fields.set("lidar.range_std_m", &mut lidar.range_std_m)?;
    fields.set("lidar.dropout", &mut lidar.dropout)?;
    fields.set("lidar.glass_visible_rad", &mut lidar.glass_visible_rad)?;
    let config = RunConfig {
        scenario: fields.text("name").unwrap_or_default().to_owned(),
        seed,
        ticks: fields.value("ticks", 1500)?,
        dt_s: fields.value("dt_s", 0.02)?,
        scan_every: fields.value("scan_every", 5)?,
        start: fields.pose("start", SE2::new(6.0, 4.5, 0.0))?,
        robot,
        lidar,
        sensors: Sensors::default(),
        script: script(&mut fields)?,
        world: world(&mut fields)?,
        kidnappings: fields.list("kidnapping", kidnapping)?,
        walkers: Vec::new(),
        crowd: None,
        events: Vec::new(),
        fleet: None,
        patches: Vec::new(),
    };
    let mut roster = fields.list("participant", participant)?;
    if roster.is_empty() {
        roster.push(Participant::new("dead-reckoning", Role::Estimator));
    }
    match fields.0.pop() {
        None => Ok((config, roster)),
        Some((key, _)) => Err(format!("{key}: this page has no such field; use sim-server launch")),
    }
}

fn script(fields: &mut Fields<'_>) -> Result<ScriptConfig, String> {
    let Some(kind) = fields.text("script.kind") else { return Ok(ScriptConfig::default()) };
    Ok(match kind {
        kind @ ("patrol" | "truth-steered-patrol") => {
            let mut patrol = PatrolConfig::default();
            fields.set("script.leg_s", &mut patrol.leg_s)?;
            match kind {
                "patrol" => ScriptConfig::Patrol(patrol),
                _ => ScriptConfig::TruthSteeredPatrol(patrol),
            }
        }
        "figure-eight" => ScriptConfig::FigureEight {
            v_m_s: fields.value("script.v_m_s", 0.5)?,
            omega_rad_s: fields.value("script.omega_rad_s", 0.6)?,
            half_s: fields.value("script.half_s", 10.48)?,
        },
        "straight" => ScriptConfig::Straight { v_m_s: fields.value("script.v_m_s", 0.0)? },
        "commands" => {
            ScriptConfig::Commands { file: None, list: fields.list("script.list", command)? }
        }
        kind => return Err(format!("script.kind={kind}: this page has no such script")),
    })
}

fn command(fields: &mut Fields<'_>, key: &str) -> Result<Option<Twist>, String> {
    let [v, omega] = ["v_m_s", "omega_rad_s"].map(|part| format!("{key}.{part}"));
    if !fields.has(&v) {
        return Ok(None);
    }
    let v_m_s = fields.value(&v, 0.0)?;
    Ok(Some(Twist { v_m_s, omega_rad_s: fields.value(&omega, 0.0)? }))
}

fn kidnapping(fields: &mut Fields<'_>, key: &str) -> Result<Option<Kidnapping>, String> {
    let tick = format!("{key}.tick");
    if !fields.has(&tick) {
        return Ok(None);
    }
    let to = fields.pose(&format!("{key}.to"), SE2::identity())?;
    Ok(Some(Kidnapping { tick: fields.value(&tick, 0)?, to }))
}

fn participant(fields: &mut Fields<'_>, key: &str) -> Result<Option<Participant>, String> {
    let Some(name) = fields.text(&format!("{key}.name")) else { return Ok(None) };
    let role = match fields.text(&format!("{key}.role")).unwrap_or("estimator") {
        "estimator" => Role::Estimator,
        "scorer" => Role::Scorer,
        "logger" => Role::Logger,
        role => return Err(format!("{key}.role={role}: this page has no such participant")),
    };
    let word = |fields: &mut Fields<'_>, key: &str| Ok(fields.text(key).map(str::to_owned));
    let command = fields.list(&format!("{key}.command"), word)?;
    let mut participant = Participant { command, ..Participant::new(name, role) };
    participant.data_sheet = match fields.text(&format!("{key}.data_sheet")) {
        Some("given") => DataSheet::Given,
        Some("hidden") => DataSheet::Hidden,
        _ => participant.data_sheet,
    };
    if fields.text(&format!("{key}.initial_pose")) == Some("hidden") {
        participant.initial_pose = Access::Hidden;
    }
    Ok(Some(participant))
}

fn world(fields: &mut Fields<'_>) -> Result<WorldSpec, String> {
    let mut bounds = [0.0; 4];
    for (i, bound) in bounds.iter_mut().enumerate() {
        fields.set(&format!("floor.bounds.{i}"), bound)?;
    }
    let walls = fields.list("floor.walls", |fields, key| {
        let material = match fields.text(&format!("{key}.4")) {
            None => return Ok(None),
            Some("glass") => Material::Glass,
            Some("door") => Material::Door(0),
            Some(_) => Material::Wall,
        };
        let mut at = [0.0; 4];
        for (i, part) in at.iter_mut().enumerate() {
            fields.set(&format!("{key}.{i}"), part)?;
        }
        Ok(Some(WallSpec { a: [at[0], at[1]], b: [at[2], at[3]], material }))
    })?;
    let name = fields.text("world").unwrap_or("apartment").to_owned();
    Ok(WorldSpec { name, bounds, walls, landmarks: Vec::new() })
}
