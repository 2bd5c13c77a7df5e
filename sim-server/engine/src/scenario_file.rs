//! Scenarios: built in or in a file, changed on the command line, set up.

mod changes;

pub use changes::change_config;

use std::io::Read as _;
use std::path::{Path, PathBuf};

use rusty_contract::input;
use rusty_contract::scenario::ScenarioError;
use rusty_contract::suggest::{did_you_mean, for_message};
use rusty_contract::{FieldError, Participant, Role, RunConfig, Scenario, ScriptConfig};
use rusty_geometry::places::{PLACES, place};
use rusty_geometry::{WorldError, WorldSpec};
use thiserror::Error;

/// The scenarios that come with the program: name and text.
pub const BUILT_IN: [(&str, &str); 6] = [
    ("apartment", include_str!("../scenarios/apartment.toml")),
    ("patrol", include_str!("../scenarios/patrol.toml")),
    ("figure-eight", include_str!("../scenarios/figure-eight.toml")),
    ("hallway", include_str!("../scenarios/hallway.toml")),
    ("driver", include_str!("../scenarios/driver.toml")),
    ("glass-lobby", include_str!("../scenarios/glass-lobby.toml")),
];

/// Longest scenario, world or list of commands that is read, bytes: 100 000
/// walls or a million commands need less.
const MAX_FILE_BYTES: u64 = 32 << 20;

/// Why a scenario cannot be set up.
#[derive(Debug, Error)]
pub enum SetupError {
    /// The file cannot be read.
    #[error("{path}: {error}{hint}")]
    Read {
        /// The file.
        path: String,
        /// What the operating system said.
        error: std::io::Error,
        /// What might have been meant.
        hint: String,
    },
    /// What is in it cannot be used.
    #[error("{path}: {error}")]
    Scenario {
        /// The file.
        path: String,
        /// What is wrong.
        error: ScenarioError,
    },
    /// A world was given as a scenario.
    #[error(
        "{path}: expected a scenario, got a world; run a scenario in it with `sim-server launch \
         --set world_file={path}`, or draw it with `sim-server worlds {path} --svg FILE`"
    )]
    WorldGiven {
        /// The file.
        path: String,
    },
    /// The world cannot be used.
    #[error("{path}: {error}{}", for_message(&error.to_string()))]
    World {
        /// The file.
        path: String,
        /// What is wrong.
        error: WorldError,
    },
    /// A field cannot be used together with the rest.
    #[error(transparent)]
    Field(#[from] FieldError),
}

/// A scenario and where its files are looked for.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// What it says.
    pub scenario: Scenario,
    /// Folder that its paths are relative to.
    pub folder: PathBuf,
}

/// Adds the estimator of `--add NAME=COMMAND`; one without a command is started by
/// hand.
pub fn add_estimator(roster: &mut Vec<Participant>, text: &str) {
    let (name, command) = match text.split_once('=') {
        Some((name, command)) => (name, command.split_whitespace().map(str::to_owned).collect()),
        None => (text, Vec::new()),
    };
    let estimator = Participant { command, ..Participant::new(name, Role::Estimator) };
    // Estimators first: they come before scorer and logger in the table.
    let place = roster.iter().take_while(|p| p.role.answers()).count();
    roster.insert(place, estimator);
}

/// Loads a built-in scenario by name, or a file by path, and applies changes
/// of the form `robot.slip_std=0.05`.
///
/// # Errors
/// [`SetupError`] names file, field, value and remedy.
pub fn load(which: &str, changes: &[String]) -> Result<Loaded, SetupError> {
    let built_in = BUILT_IN.iter().find(|(name, _)| *name == which);
    let (text, folder) = match built_in {
        Some((_, text)) => ((*text).to_owned(), PathBuf::new()),
        None => {
            let path = Path::new(which);
            let text = read_text(path).map_err(|error| {
                let mut hint = names("scenarios", which, BUILT_IN.iter().map(|(name, _)| *name));
                if place(which).is_some() {
                    hint = format!("{hint}; for the world of this name use --set world={which}");
                }
                SetupError::Read { path: which.to_owned(), error, hint }
            })?;
            (text, path.parent().map(Path::to_owned).unwrap_or_default())
        }
    };
    let mut scenario = read(&text, changes).map_err(|error| {
        let path = which.to_owned();
        match parse_world(Path::new(which), &text) {
            Ok(_) => SetupError::WorldGiven { path },
            Err(_) => SetupError::Scenario { path, error },
        }
    })?;
    for participant in &mut scenario.participants {
        for file in &mut participant.files {
            *file = folder.join(&*file).to_string_lossy().into_owned();
        }
        for (place, word) in participant.command.iter_mut().enumerate() {
            if let Some(path) = beside_the_scenario(&folder, place, word) {
                *word = path;
            }
        }
    }
    Ok(Loaded { scenario, folder })
}

/// Returns the end of a message about a name that is not built in.
fn names<'a>(what: &str, word: &str, all: impl Iterator<Item = &'a str>) -> String {
    let all: Vec<&str> = all.collect();
    let suggestion = did_you_mean(word, all.iter().copied());
    format!("; built-in {what}: {}{suggestion}", all.join(", "))
}

/// A word of a command that names no file where the server works, but one beside
/// the scenario: `command = ["python3", "my_filter.py"]` works from anywhere.
fn beside_the_scenario(folder: &Path, place: usize, word: &str) -> Option<String> {
    // A bare program is looked up elsewhere.
    let names_a_file = place > 0 || word.contains('/');
    if !names_a_file || word.starts_with('-') || Path::new(word).exists() {
        return None;
    }
    let path = folder.join(word);
    path.is_file().then(|| path.to_string_lossy().into_owned())
}

/// The text of a file, if it is no longer than any that can be meant.
fn read_text(path: &Path) -> std::io::Result<String> {
    let mut text = String::new();
    input::open(path)?.take(MAX_FILE_BYTES + 1).read_to_string(&mut text)?;
    if text.len() as u64 > MAX_FILE_BYTES {
        let problem = format!("longer than {MAX_FILE_BYTES} bytes; is this the right file?");
        return Err(std::io::Error::other(problem));
    }
    Ok(text)
}

/// Reads the text of a scenario and applies changes to it.
///
/// # Errors
/// [`ScenarioError`] names field, value and remedy.
pub fn read(text: &str, changes: &[String]) -> Result<Scenario, ScenarioError> {
    let scenario = Scenario::from_toml(text)?;
    if changes.is_empty() { Ok(scenario) } else { changes::change(text, changes) }
}

/// Reads a world: a built-in place by name, or a file by path.
///
/// # Errors
/// [`SetupError`] names the file and the wall.
pub fn world(which: &str) -> Result<WorldSpec, SetupError> {
    if let Some(place) = place(which) {
        return Ok(place.spec().clone());
    }
    world_file(Path::new(which))
}

fn world_file(path: &Path) -> Result<WorldSpec, SetupError> {
    let name = path.display().to_string();
    let text = read_text(path).map_err(|error| {
        let hint = names("worlds", &name, PLACES.iter().map(|(name, _)| *name));
        SetupError::Read { path: name.clone(), error, hint }
    })?;
    let error = |error| SetupError::World { path: name.clone(), error };
    let spec = parse_world(path, &text).map_err(error)?;
    spec.check().map_err(error)?;
    Ok(spec)
}

fn parse_world(path: &Path, text: &str) -> Result<WorldSpec, WorldError> {
    let is_json = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json"));
    if is_json { WorldSpec::from_json_str(text) } else { WorldSpec::from_toml_str(text) }
}

impl Loaded {
    /// The configuration of the run, with all files read.
    ///
    /// # Errors
    /// [`SetupError`] names file, field, value and remedy.
    pub fn config(&self) -> Result<RunConfig, SetupError> {
        let s = &self.scenario;
        let world = match &s.world_file {
            Some(file) => world_file(&self.folder.join(file))?,
            None => match place(&s.world) {
                Some(place) => place.spec().clone(),
                None => {
                    let hint = did_you_mean(&s.world, PLACES.iter().map(|(name, _)| *name));
                    let remedy =
                        format!("use open, hallway or apartment, or give a world_file{hint}");
                    let problem = "is no built-in world";
                    return Err(FieldError::new("world", &s.world, problem, remedy).into());
                }
            },
        };
        let mut script = s.script.clone();
        if let ScriptConfig::Commands { file: Some(file), list } = &mut script {
            let path = self.folder.join(&*file);
            let text = read_text(&path).map_err(|error| SetupError::Read {
                path: path.display().to_string(),
                error,
                hint: String::new(),
            })?;
            *list = rusty_contract::config::parse_commands(&text)?;
        }
        let config = RunConfig {
            scenario: s.name.clone(),
            seed: s.seed,
            ticks: s.ticks,
            dt_s: s.dt_s,
            scan_every: s.scan_every,
            start: s.start,
            robot: s.robot,
            lidar: s.lidar,
            sensors: s.sensors.clone(),
            script,
            world,
            kidnappings: s.kidnappings.clone(),
        };
        config.check()?;
        Ok(config)
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn every_built_in_scenario_can_be_set_up() {
        for (name, _) in BUILT_IN {
            let loaded = load(name, &[]).unwrap();
            assert_eq!(loaded.scenario.name, name);
            loaded.config().unwrap();
        }
    }

    #[test]
    fn a_script_beside_the_scenario_is_found_from_anywhere() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("my_filter.py"), "").unwrap();
        let command = r#"["./my_filter.py", "my_filter.py", "-my_filter.py", "absent.py", "src"]"#;
        let bare = r#"["my_filter.py"]"#;
        let text = format!(
            "[[participant]]\nname = \"a\"\ncommand = {command}\n\
             [[participant]]\nname = \"b\"\ncommand = {bare}\n"
        );
        fs::write(at("s.toml"), text).unwrap();
        let loaded = load(at("s.toml").to_str().unwrap(), &[]).unwrap();
        let found = at("my_filter.py").to_str().unwrap().to_owned();
        let dotted = at("./my_filter.py").to_str().unwrap().to_owned();
        let commands = loaded.scenario.participants.iter().map(|p| p.command.as_slice());
        let commands: Vec<&[String]> = commands.collect();
        // What is there for the server as it is written stays as it is.
        assert_eq!(commands[0], [&dotted, &found, "-my_filter.py", "absent.py", "src"]);
        assert_eq!(commands[1], ["my_filter.py"]);
    }

    #[test]
    fn a_file_without_end_is_refused() {
        let error = load("/dev/zero", &[]).unwrap_err().to_string();
        assert!(error.contains("/dev/zero: expected a regular file"), "{error}");
        let long = tempfile::NamedTempFile::new().unwrap();
        long.as_file().set_len(MAX_FILE_BYTES + 1).unwrap();
        let path = long.path().to_str().unwrap();
        let error = load(path, &[]).unwrap_err().to_string();
        assert!(error.contains(&format!("{path}: longer than")), "{error}");
    }

    #[test]
    fn a_name_that_is_almost_right_gets_a_suggestion() {
        let error = |which: &str| load(which, &[]).unwrap_err().to_string();
        assert!(
            error("apartmnt").ends_with("did you mean \"apartment\"?"),
            "{}",
            error("apartmnt")
        );
        assert!(error("open").contains("--set world=open"), "a world: {}", error("open"));
        let set = ["world=halway".to_owned()];
        let error = load("patrol", &set).unwrap().config().unwrap_err().to_string();
        assert!(error.contains("world = halway") && error.contains("did you mean \"hallway\"?"));
        let error = world("apartmnt").unwrap_err().to_string();
        assert!(error.ends_with("did you mean \"apartment\"?"), "{error}");
    }

    #[test]
    fn a_world_file_in_the_place_of_a_scenario_is_recognised() {
        let folder = tempfile::tempdir().unwrap();
        let spec = rusty_geometry::hallway().spec().clone();
        let json = serde_json::to_string(&spec).unwrap();
        let toml = toml::to_string(&spec).unwrap();
        for (name, text) in [("w.json", json), ("w.toml", toml)] {
            let path = folder.path().join(name);
            fs::write(&path, text).unwrap();
            let path = path.to_str().unwrap();
            let error = load(path, &[]).unwrap_err();
            assert!(matches!(error, SetupError::WorldGiven { .. }), "{error}");
            let remedy = format!("--set world_file={path}");
            assert!(error.to_string().contains(&remedy), "{error}");
            load("hallway", &[format!("world_file={path}")]).unwrap().config().unwrap();
        }
        let path = folder.path().join("empty.json");
        fs::write(&path, "{}").unwrap();
        let error = load(path.to_str().unwrap(), &[]).unwrap_err();
        assert!(matches!(error, SetupError::Scenario { .. }), "{error}");
    }
}
