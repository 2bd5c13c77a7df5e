//! Scenarios: built in or in a file, changed on the command line, set up.

mod changes;
mod files;

pub use changes::{change_config, check_options};

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use rusty_contract::input;
use rusty_contract::scenario::{Robots, ScenarioError};
use rusty_contract::suggest::did_you_mean;
use rusty_contract::{FieldError, Participant, Role, RunConfig, Scenario, ScriptConfig};
use rusty_geometry::places::{PLACES, place};
use rusty_geometry::{Twist, WorldSpec};
use thiserror::Error;

use crate::shell;

/// The scenarios that come with the program: name and text.
pub const BUILT_IN: [(&str, &str); 15] = [
    ("apartment", include_str!("../scenarios/apartment.toml")),
    ("patrol", include_str!("../scenarios/patrol.toml")),
    ("figure-eight", include_str!("../scenarios/figure-eight.toml")),
    ("hallway", include_str!("../scenarios/hallway.toml")),
    ("driver", include_str!("../scenarios/driver.toml")),
    ("office", include_str!("../scenarios/office.toml")),
    ("sonar-ring", include_str!("../scenarios/sonar-ring.toml")),
    ("seed-lab", include_str!("../scenarios/seed-lab.toml")),
    ("anatomy", include_str!("../scenarios/anatomy.toml")),
    ("glass-lobby", include_str!("../scenarios/glass-lobby.toml")),
    ("two-robots", include_str!("../scenarios/two-robots.toml")),
    ("long-corridor", include_str!("../scenarios/long-corridor.toml")),
    ("symmetric-rooms", include_str!("../scenarios/symmetric-rooms.toml")),
    ("workshop", include_str!("../scenarios/workshop.toml")),
    ("warehouse", include_str!("../scenarios/warehouse.toml")),
];

/// Longest scenario or list of commands that is read, bytes: a million commands
/// need less.
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
         --set world_file={0}`, or draw it with `sim-server worlds {0} --svg FILE`",
        shell::quoted(path)
    )]
    WorldGiven {
        /// The file.
        path: String,
    },
    /// The world file cannot be used, as its reader reports.
    #[error("{0}")]
    WorldFile(Box<dyn std::error::Error + Send + Sync>),
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

/// Adds the estimator of an option like `--add NAME=COMMAND`; one without a command is
/// started by hand.
///
/// # Errors
/// [`FieldError`] where the command is no words.
pub fn add_estimator(
    roster: &mut Vec<Participant>,
    option: &str,
    text: &str,
) -> Result<(), FieldError> {
    let (name, command) = match text.split_once('=') {
        Some((_, command)) if command.trim().is_empty() => {
            let remedy = "give NAME=COMMAND, or NAME alone for one that is started by hand";
            return Err(FieldError::new(option, text, "has no command", remedy));
        }
        Some((name, command)) => (name, shell::words(option, command)?),
        None => (text, Vec::new()),
    };
    let estimator = Participant { command, ..Participant::new(name, Role::Estimator) };
    // Estimators first: they come before scorer and logger in the table.
    let place = roster.iter().take_while(|p| p.role.answers()).count();
    roster.insert(place, estimator);
    Ok(())
}

/// Loads a built-in scenario by name, or a file by path, and applies changes
/// of the form `robot.slip_std=0.05`.
///
/// # Errors
/// [`SetupError`] names file, field, value and remedy.
pub fn load(which: &str, changes: &[String]) -> Result<Loaded, SetupError> {
    let loaded = load_unchecked(which, changes)?;
    let checked = loaded.scenario.check();
    checked.map_err(|error| SetupError::Scenario { path: which.to_owned(), error })?;
    Ok(loaded)
}

/// As [`load`], for a caller that changes the scenario further and checks it then: a
/// change may fit only the roster that results.
///
/// # Errors
/// As [`load`].
pub fn load_unchecked(which: &str, changes: &[String]) -> Result<Loaded, SetupError> {
    let built_in = BUILT_IN.iter().find(|(name, _)| *name == which);
    let (text, folder) = match built_in {
        Some((_, text)) => ((*text).to_owned(), PathBuf::new()),
        None => {
            let path = Path::new(which);
            let text = input::read_text_at_most(path, MAX_FILE_BYTES).map_err(|error| {
                let hint = hint(which, &error);
                SetupError::Read { path: which.to_owned(), error, hint }
            })?;
            (text, path.parent().map(Path::to_owned).unwrap_or_default())
        }
    };
    let mut scenario = read_unchecked(&text, changes).map_err(|error| {
        let path = which.to_owned();
        match is_world(Path::new(which), &text) {
            true => SetupError::WorldGiven { path },
            false => SetupError::Scenario { path, error },
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

/// What might have been meant with a scenario that cannot be read.
fn hint(which: &str, error: &std::io::Error) -> String {
    match error.kind() {
        ErrorKind::NotFound => {}
        ErrorKind::InvalidData => {
            let remedy = "save it as UTF-8, or use `sim-server replay` if it is a log";
            return format!("; {remedy}");
        }
        ErrorKind::IsADirectory => return "; give the scenario file in it".to_owned(),
        _ => return String::new(),
    }
    let names = BUILT_IN.map(|(name, _)| name);
    let suggestion = did_you_mean(which, names);
    let hint = format!("; built-in scenarios: {}{suggestion}", names.join(", "));
    match place(which) {
        Some(_) => format!("{hint}; for the world of this name use --set world={which}"),
        None => hint,
    }
}

/// A word of a command that names no file where the server works, but one next to
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

/// Reads the text of a scenario and applies changes to it.
///
/// # Errors
/// [`ScenarioError`] names field, value and remedy.
pub fn read(text: &str, changes: &[String]) -> Result<Scenario, ScenarioError> {
    let scenario = read_unchecked(text, changes)?;
    scenario.check()?;
    Ok(scenario)
}

/// Reads and checks the text of a scenario, and applies changes that are not checked.
fn read_unchecked(text: &str, changes: &[String]) -> Result<Scenario, ScenarioError> {
    Ok(changes::changed(&Scenario::from_toml(text)?, changes)?)
}

/// The names of all built-in worlds.
fn places() -> String {
    PLACES.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ")
}

/// Whether a file given as a scenario is a world: by its ending, or by its text.
fn is_world(path: &Path, text: &str) -> bool {
    let ending = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
    match ending.to_ascii_lowercase().as_str() {
        "yaml" | "yml" | "svg" => true,
        "json" => WorldSpec::from_json_str(text).is_ok(),
        _ => WorldSpec::from_toml_str(text).is_ok(),
    }
}

impl Loaded {
    /// Returns the configuration of a run in a built-in world.
    ///
    /// # Errors
    /// [`SetupError`] names file, field, value and remedy. A `world_file` is one:
    /// see [`Loaded::config_with`].
    pub fn config(&self) -> Result<RunConfig, SetupError> {
        self.config_with(|path| {
            let problem = "is not read by this program";
            let remedy = format!("give a built-in world: {}", places());
            Err(FieldError::new("world_file", path.display(), problem, remedy))
        })
    }

    /// Returns the configuration of the run (of the first robot's, where there are
    /// several), with all files read; `read_world` reads and checks a world file, whose
    /// formats the engine does not know.
    ///
    /// # Errors
    /// [`SetupError`] names file, field, value and remedy.
    pub fn config_with<E: std::error::Error + Send + Sync + 'static>(
        &self,
        read_world: impl FnOnce(&Path) -> Result<WorldSpec, E>,
    ) -> Result<RunConfig, SetupError> {
        Ok(self.configs_with(read_world)?.swap_remove(0))
    }

    /// Returns the configurations of the runs of all robots, in the order of their
    /// places; see [`Loaded::config_with`].
    ///
    /// # Errors
    /// [`SetupError`] names file, field, value and remedy.
    pub fn configs_with<E: std::error::Error + Send + Sync + 'static>(
        &self,
        read_world: impl FnOnce(&Path) -> Result<WorldSpec, E>,
    ) -> Result<Vec<RunConfig>, SetupError> {
        let s = &self.scenario;
        let world = match &s.world_file {
            Some(file) => read_world(&self.folder.join(file))
                .map_err(|error| SetupError::WorldFile(Box::new(error)))?,
            None => match place(&s.world) {
                Some(place) => place.spec().clone(),
                None => {
                    let hint = did_you_mean(&s.world, PLACES.iter().map(|(name, _)| *name));
                    let remedy = format!("use {}, or give a world_file{hint}", places());
                    let problem = "is no built-in world";
                    return Err(FieldError::new("world", &s.world, problem, remedy).into());
                }
            },
        };
        let mut scenario = s.clone();
        self.read_script(&mut scenario.script)?;
        if let Robots::Several(robots) = &mut scenario.robot {
            let mut scripts = robots.iter_mut().filter_map(|robot| robot.own.script.as_mut());
            scripts.try_for_each(|script| self.read_script(script))?;
        }
        let places = 0..scenario.robot.entries().len().max(1);
        let config = |place| {
            let config = scenario.config_of(place, world.clone());
            config.check()?;
            Ok(config)
        };
        places.map(config).collect()
    }

    /// Reads the commands of a script that names a file.
    fn read_script(&self, script: &mut ScriptConfig) -> Result<(), SetupError> {
        let ScriptConfig::Commands { file, list } = script else { return Ok(()) };
        if let Some(file) = file {
            *list = self.read_commands(file)?;
        }
        if list.is_empty() {
            let remedy = "give `file` or `list`, with a command for a tick at least";
            return Err(FieldError::new("script", "commands", "has no command", remedy).into());
        }
        Ok(())
    }

    fn read_commands(&self, file: &str) -> Result<Vec<Twist>, SetupError> {
        let path = self.folder.join(file);
        let text = input::read_text_at_most(&path, MAX_FILE_BYTES);
        let path = path.display().to_string();
        let text = text.map_err(|error| SetupError::Read {
            path: path.clone(),
            error,
            hint: String::new(),
        })?;
        Ok(rusty_contract::config::parse_commands(&path, &text)?)
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
    fn a_change_may_fit_only_the_roster_that_results() {
        let set = ["script.kind=patrol".to_owned()];
        assert!(matches!(load("driver", &set), Err(SetupError::Scenario { .. })));
        let mut scenario = load_unchecked("driver", &set).unwrap().scenario;
        scenario.participants.retain(|p| p.role != Role::Driver);
        scenario.check().unwrap();
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
    }

    #[test]
    fn a_world_file_in_the_place_of_a_scenario_is_recognised() {
        let folder = tempfile::tempdir().unwrap();
        let spec = rusty_geometry::hallway().spec().clone();
        let json = serde_json::to_string(&spec).unwrap();
        let toml = toml::to_string(&spec).unwrap();
        let svg = "<svg/>".to_owned();
        for (name, text) in [("w.json", json), ("w.toml", toml), ("w.svg", svg)] {
            let path = folder.path().join(name);
            fs::write(&path, text).unwrap();
            let path = path.to_str().unwrap();
            let error = load(path, &[]).unwrap_err();
            assert!(matches!(error, SetupError::WorldGiven { .. }), "{error}");
            let remedy = format!("--set world_file={path}");
            assert!(error.to_string().contains(&remedy), "{error}");
            let loaded = load("hallway", &[format!("world_file={path}")]).unwrap();
            let given = loaded.config_with(|_| Ok::<_, FieldError>(spec.clone())).unwrap();
            assert_eq!(given.world, spec);
            let error = loaded.config().unwrap_err().to_string();
            assert!(error.contains(&format!("world_file = {path}: ")), "{error}");
        }
        let path = folder.path().join("empty.json");
        fs::write(&path, "{}").unwrap();
        let error = load(path.to_str().unwrap(), &[]).unwrap_err();
        assert!(matches!(error, SetupError::Scenario { .. }), "{error}");
    }
}
