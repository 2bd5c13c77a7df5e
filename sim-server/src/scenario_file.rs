//! Scenarios: built in or in a file, changed on the command line, set up.

use std::fs;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use rusty_contract::scenario::ScenarioError;
use rusty_contract::{FieldError, Participant, Role, RunConfig, Scenario, ScriptConfig};
use rusty_geometry::{WorldError, WorldSpec};
use thiserror::Error;

/// The scenarios that come with the program: name and text.
pub const BUILT_IN: [(&str, &str); 5] = [
    ("apartment", include_str!("../scenarios/apartment.toml")),
    ("patrol", include_str!("../scenarios/patrol.toml")),
    ("figure-eight", include_str!("../scenarios/figure-eight.toml")),
    ("hallway", include_str!("../scenarios/hallway.toml")),
    ("driver", include_str!("../scenarios/driver.toml")),
];

/// Longest scenario, world or list of commands that is read, bytes: 100 000
/// walls or a million commands need less.
const MAX_FILE_BYTES: u64 = 32 << 20;

/// The most parts of a `--set` key; no field lies deeper.
const MAX_KEY_PARTS: usize = 16;

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
    /// The world cannot be used.
    #[error("{path}: {error}")]
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
                let names: Vec<&str> = BUILT_IN.iter().map(|(name, _)| *name).collect();
                let hint = format!("; built-in scenarios: {}", names.join(", "));
                SetupError::Read { path: which.to_owned(), error, hint }
            })?;
            (text, path.parent().map(Path::to_owned).unwrap_or_default())
        }
    };
    let error = |error| SetupError::Scenario { path: which.to_owned(), error };
    let mut scenario = read(&text, changes).map_err(error)?;
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
    fs::File::open(path)?.take(MAX_FILE_BYTES + 1).read_to_string(&mut text)?;
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
    if changes.is_empty() { Ok(scenario) } else { change(text, changes) }
}

/// Applies `key=value` changes to the text of a scenario.
fn change(text: &str, changes: &[String]) -> Result<Scenario, ScenarioError> {
    let syntax = |e: toml::de::Error| ScenarioError::Syntax(e.to_string().trim_end().to_owned());
    let mut table: toml::Table = toml::from_str(text).map_err(syntax)?;
    for change in changes {
        let (key, value) = parse_change(change)?;
        // Whoever walks through tables in tables needs stack for each.
        if key.split('.').count() > MAX_KEY_PARTS {
            return Err(change_error(change, "names a field that no scenario has").into());
        }
        let mut place = &mut table;
        let mut parts = key.trim().split('.').peekable();
        while let Some(part) = parts.next() {
            if parts.peek().is_none() {
                place.insert(part.to_owned(), value);
                break;
            }
            let next = place
                .entry(part.to_owned())
                .or_insert_with(|| toml::Value::Table(toml::Table::new()));
            let through = || change_error(change, "goes through a value");
            place = next.as_table_mut().ok_or_else(through)?;
        }
    }
    Scenario::from_toml(&table.to_string())
}

fn change_error(change: &str, problem: &str) -> FieldError {
    let remedy = "write --set key=value, e.g. --set robot.slip_std=0.05";
    FieldError::new("--set", change, problem, remedy)
}

/// Key and value of `key=value`.
fn parse_change(change: &str) -> Result<(&str, toml::Value), FieldError> {
    let (key, value) = change.split_once('=').ok_or_else(|| change_error(change, "has no `=`"))?;
    // A word that is no TOML value is meant as text.
    let value = toml::from_str::<toml::Table>(&format!("v = {value}"))
        .ok()
        .and_then(|mut t| t.remove("v"))
        .unwrap_or_else(|| toml::Value::String(value.to_owned()));
    Ok((key, value))
}

/// Applies `key=value` changes to the configuration of a run.
///
/// # Errors
/// [`FieldError`] names the change that cannot be made.
pub fn change_config(config: &RunConfig, changes: &[String]) -> Result<RunConfig, FieldError> {
    let mut config = config.clone();
    for change in changes {
        let error =
            |e: &dyn std::fmt::Display| change_error(change, &format!("cannot be set: {e}"));
        let (key, value) = parse_change(change)?;
        // JSON, because TOML has no room for a seed of 64 bits.
        let mut whole = serde_json::to_value(&config).map_err(|e| error(&e))?;
        let mut place = &mut whole;
        for part in key.trim().split('.') {
            let inside = place.as_object_mut();
            place = inside
                .ok_or_else(|| change_error(change, "goes through a value"))?
                .entry(part)
                .or_insert(serde_json::Value::Null);
        }
        *place = serde_json::to_value(value).map_err(|e| error(&e))?;
        config = serde_json::from_value(whole).map_err(|e| error(&e))?;
    }
    Ok(config)
}

/// Reads a world: a built-in place by name, or a file by path.
///
/// # Errors
/// [`SetupError`] names the file and the wall.
pub fn world(which: &str) -> Result<WorldSpec, SetupError> {
    if let Some(place) = rusty_geometry::places::place(which) {
        return Ok(place.spec().clone());
    }
    world_file(Path::new(which))
}

fn world_file(path: &Path) -> Result<WorldSpec, SetupError> {
    let name = path.display().to_string();
    let text = read_text(path).map_err(|error| {
        let places: Vec<&str> = rusty_geometry::places::PLACES.iter().map(|(n, _)| *n).collect();
        let hint = format!("; built-in worlds: {}", places.join(", "));
        SetupError::Read { path: name.clone(), error, hint }
    })?;
    let is_json = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json"));
    let spec =
        if is_json { WorldSpec::from_json_str(&text) } else { WorldSpec::from_toml_str(&text) };
    let error = |error| SetupError::World { path: name.clone(), error };
    let spec = spec.map_err(error)?;
    spec.check().map_err(error)?;
    Ok(spec)
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
            None => match rusty_geometry::places::place(&s.world) {
                Some(place) => place.spec().clone(),
                None => {
                    let remedy = "use open, hallway or apartment, or give a world_file";
                    return Err(
                        FieldError::new("world", &s.world, "is no built-in world", remedy).into()
                    );
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
        assert!(error.contains("/dev/zero: longer than"), "{error}");
    }

    #[test]
    fn a_change_of_a_configuration_leaves_every_other_bit() {
        let mut config = load("apartment", &[]).unwrap().config().unwrap();
        config.seed = u64::MAX;
        config.dt_s = 0.1 + 0.2;
        let set = |text: &str| change_config(&config, &[text.to_owned()]);
        let mut expected = config.clone();
        expected.robot.slip_std = 1.0;
        assert_eq!(set("robot.slip_std=1"), Ok(expected.clone()));
        expected.robot.slip_std = config.robot.slip_std;
        expected.script = ScriptConfig::Straight { v_m_s: 0.25 };
        assert_eq!(set("script={ kind = \"straight\", v_m_s = 0.25 }"), Ok(expected));
        for (text, words) in [
            ("robot.slip_std", "has no `=`"),
            ("robot.slip=0.1", "unknown field `slip`"),
            ("seed.x=1", "goes through a value"),
            ("robot.slip_std=much", "invalid type: string \"much\""),
        ] {
            let error = set(text).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        }
    }

    #[test]
    fn a_change_reaches_its_field_and_a_wrong_one_is_named() {
        let set = |text: &str| load("apartment", &[text.to_owned()]);
        assert_eq!(set("lidar.beams=181").unwrap().scenario.lidar.beams, 181);
        assert_eq!(
            set("on_loss=continue").unwrap().scenario.on_loss,
            rusty_contract::OnLoss::Continue
        );
        assert!(set("lidar.beems=181").unwrap_err().to_string().contains("beems"));
        assert!(set("lidar.beams").unwrap_err().to_string().contains("has no `=`"));
        let deep = format!("{}a=1", "a.".repeat(100_000));
        assert!(set(&deep).unwrap_err().to_string().contains("no scenario has"));
        assert!(set("robot.slip_std=nan").unwrap_err().to_string().contains("NaN"));
    }
}
