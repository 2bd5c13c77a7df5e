//! Changes of the form `robot.slip_std=0.05`: the option `--set`.

use std::collections::BTreeSet;

use rusty_contract::scenario::has_null;
use rusty_contract::suggest::{for_message, without_types};
use rusty_contract::{FieldError, JsonTree, RunConfig};
use serde_json::{Map, Value};

/// The most parts of a `--set` key; no field lies deeper.
const MAX_KEY_PARTS: usize = 16;

/// Fields that have another name in a run's configuration than in a scenario.
const RENAMED: [(&str, &str); 4] = [
    ("kidnapping", "kidnappings"),
    ("event", "events"),
    ("patch", "patches"),
    ("walker", "walkers"),
];

/// Fields of a scenario that a run keeps from its beginning, under other names or none.
const FIXED: [&str; 4] = ["name", "world", "world_file", "participant"];

/// Applies `key=value` changes, in the words of a scenario, to the configuration of a run.
///
/// # Errors
/// [`FieldError`] names the change that cannot be made.
pub fn change_config(config: &RunConfig, changes: &[String]) -> Result<RunConfig, FieldError> {
    let is_fixed = |change: &&String| {
        let key = change.split(['=', '.']).next().unwrap_or_default();
        FIXED.contains(&key.trim())
    };
    if let Some(change) = changes.iter().find(is_fixed) {
        let (problem, remedy) = ("is fixed when a run begins", "start another run with it");
        return Err(FieldError::new("--set", change, problem, remedy));
    }
    let of_config = |change: &String| {
        let (key, value) = change.split_once('=').unwrap_or((change, ""));
        let renamed = RENAMED.iter().find(|(name, _)| *name == key.trim());
        renamed.map_or_else(|| change.clone(), |(_, name)| format!("{name}={value}"))
    };
    changed(config, &changes.iter().map(of_config).collect::<Vec<_>>())
}

/// Refuses a change of a field for which an option was given as well: each of `given` is
/// the key, the option, and whether it was given.
///
/// # Errors
/// [`FieldError`] names both.
pub fn check_options(changes: &[String], given: &[(&str, &str, bool)]) -> Result<(), FieldError> {
    for (key, option, _) in given.iter().filter(|(.., is_given)| *is_given) {
        let is_of_it = |change: &&String| change.split('=').next().map(str::trim) == Some(*key);
        if let Some(change) = changes.iter().find(is_of_it) {
            let problem = format!("is set by {option} as well");
            return Err(FieldError::new("--set", change, problem, "leave out one of both"));
        }
    }
    Ok(())
}

/// Returns an unchecked copy with the changes, which are made in JSON: the integers of TOML
/// have a sign, and no room for a seed of 64 bits.
///
/// # Errors
/// [`FieldError`] names the change that cannot be made.
pub(super) fn changed<T>(original: &T, changes: &[String]) -> Result<T, FieldError>
where
    T: Clone + JsonTree,
{
    let error = |change: &String, e: &serde_json::Error| value_error(change, &e.to_string());
    let mut latest = original.clone();
    let mut whole = Value::Null;
    // The change to blame, and the problem. A later change may complete an
    // earlier one: `script.kind`, then `script.v_m_s`.
    let mut wrong: Option<FieldError> = None;
    let mut problem = String::new();
    let mut keys = BTreeSet::new();
    for change in changes {
        let key = change.split('=').next().unwrap_or_default().trim();
        if !keys.insert(key) {
            return Err(FieldError::new("--set", change, "sets a field again", "give it once"));
        }
        if whole.is_null() {
            whole = original.to_tree().map_err(|e| error(change, &e))?;
        }
        set(&mut whole, change)?;
        match T::from_tree(&whole) {
            Ok(read) => (latest, wrong) = (read, None),
            Err(e) if wrong.is_some() && e.to_string() == problem => {}
            Err(e) => (problem, wrong) = (e.to_string(), Some(error(change, &e))),
        }
    }
    wrong.map_or(Ok(latest), Err)
}

/// Sets one field.
fn set(whole: &mut Value, change: &str) -> Result<(), FieldError> {
    let (key, value) = parse_change(change)?;
    let key = key.trim();
    // A parser of tables in tables needs stack for each.
    if key.split('.').count() > MAX_KEY_PARTS {
        return Err(change_error(change, "names a field that no scenario has"));
    }
    if key == "world" {
        // A scenario takes its world from this file, if it has one.
        whole.as_object_mut().map(|fields| fields.remove("world_file"));
    }
    let mut place = whole;
    for part in key.split('.') {
        if place.is_null() {
            *place = Value::Object(Map::new());
        }
        if place.is_array() {
            let problem = "goes into a list, which --set does not reach into";
            return Err(FieldError::new("--set", change, problem, "change the scenario file"));
        }
        let fields =
            place.as_object_mut().ok_or_else(|| change_error(change, "goes through a value"))?;
        if part == "kind" && fields.get(part).is_some_and(|kind| *kind != value) {
            // The other fields are parameters of the kind that was there.
            fields.clear();
        }
        place = fields.entry(part).or_insert(Value::Null);
    }
    *place = value;
    Ok(())
}

/// The error of a change whose field or value a parser does not take.
fn value_error(change: &str, message: &str) -> FieldError {
    let mut remedy = for_message(message).trim_start_matches("; ").to_owned();
    if remedy.is_empty() {
        "give a field and a value that it takes".clone_into(&mut remedy);
    }
    FieldError::new("--set", change, without_types(message), remedy)
}

fn change_error(change: &str, problem: &str) -> FieldError {
    let remedy = "write --set key=value, e.g. --set robot.slip_std=0.05";
    FieldError::new("--set", change, problem, remedy)
}

/// Key and value of `key=value`.
fn parse_change(change: &str) -> Result<(&str, Value), FieldError> {
    let (key, value) = change.split_once('=').ok_or_else(|| change_error(change, "has no `=`"))?;
    // A word that is no TOML value is meant as text.
    let value = toml::from_str::<Map<String, Value>>(&format!("v = {value}"))
        .ok()
        .and_then(|mut table| table.remove("v"))
        .unwrap_or_else(|| Value::String(value.to_owned()));
    if has_null(&value) {
        let problem = "is NaN or infinite, which no field takes";
        return Err(FieldError::new("--set", change, problem, "give a finite number"));
    }
    Ok((key, value))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario_file::{load, read};
    use rusty_contract::ScriptConfig;

    #[test]
    fn a_world_takes_the_place_of_a_world_file() {
        let world = |changes: &[&str]| {
            let changes: Vec<String> = changes.iter().map(|&c| c.to_owned()).collect();
            let scenario = read("world_file = \"hall.toml\"", &changes).unwrap();
            (scenario.world, scenario.world_file)
        };
        assert_eq!(world(&["ticks=5"]).1.as_deref(), Some("hall.toml"));
        assert_eq!(world(&["world=lobby"]), ("lobby".to_owned(), None));
        let both = ["world=lobby", "world_file=other.toml"];
        assert_eq!(world(&both).1.as_deref(), Some("other.toml"));
    }

    #[test]
    fn a_seed_may_have_64_bits() {
        let seed = |changes: &[&str]| {
            let changes: Vec<String> = changes.iter().map(|&c| c.to_owned()).collect();
            load("apartment", &changes).unwrap().scenario.seed
        };
        assert_eq!(seed(&["seed=18446744073709551615", "ticks=5"]), u64::MAX);
        assert_eq!(seed(&["ticks=5", "seed=9223372036854775808"]), 1 << 63);
        let config = load("apartment", &[]).unwrap().config().unwrap();
        let change = |text: &str| change_config(&config, &[text.to_owned()]).unwrap().seed;
        assert_eq!((change("seed = 18446744073709551615"), change("seed=7")), (u64::MAX, 7));
        assert!(load("apartment", &["seed=18446744073709551616".to_owned()]).is_err());
        let file = "seed = 18446744073709551615";
        assert_eq!(read(file, &["ticks=5".to_owned()]).unwrap().seed, u64::MAX);
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
        for text in ["robot.slip_std=nan", "start.x_m=-inf", "script={kind='straight',v_m_s=nan}"] {
            let error = set(text).unwrap_err().to_string();
            assert!(error.contains(text) && error.contains("finite"), "{error}");
        }
    }

    #[test]
    fn a_field_is_set_once() {
        let changes = ["robot.slip_std=0.1", "robot.slip_std =0.2"].map(str::to_owned);
        let error = load("apartment", &changes).unwrap_err().to_string();
        assert!(error.contains(&changes[1]) && error.contains("again"), "{error}");
        let changes = ["ticks=50".to_owned()];
        let given = |ticks: bool| [("seed", "--seed", true), ("ticks", "--ticks", ticks)];
        assert_eq!(check_options(&changes, &given(false)), Ok(()));
        let error = check_options(&changes, &given(true)).unwrap_err();
        assert!(error.to_string().contains("--ticks") && error.value == "ticks=50", "{error}");
    }

    #[test]
    fn a_configuration_takes_the_names_of_a_scenario() {
        let config = load("apartment", &[]).unwrap().config().unwrap();
        let text = "kidnapping=[{tick=5,to={x_m=3,y_m=1,theta_rad=0}}]".to_owned();
        assert_eq!(change_config(&config, &[text]).unwrap().kidnappings[0].tick, 5);
        for fixed in ["world=open", "world.name=x", "world_file=a.toml", "name=x"] {
            let refused = change_config(&config, &[fixed.to_owned()]).unwrap_err().to_string();
            assert!(refused.contains(fixed) && refused.contains("another run"), "{refused}");
        }
    }

    #[test]
    fn the_option_to_blame_is_named_as_it_was_typed() {
        let error = |changes: &[&str]| {
            let changes: Vec<String> = changes.iter().map(|&c| c.to_owned()).collect();
            load("apartment", &changes).unwrap_err().to_string()
        };
        for (changes, option) in [
            (&["robot.foo=1"][..], "--set robot.foo=1: "),
            (&["robot.slip_std=much", "seed=7"], "--set robot.slip_std=much: "),
            (&["seed=7", "lidar.beams=-1"], "--set lidar.beams=-1: "),
            (&["script.kind=straight", "script.v_m_s=x"], "--set script.v_m_s=x: "),
            (&["script.kind=straight"], "--set script.kind=straight: "),
        ] {
            let error = error(changes);
            assert!(error.contains(option) && !error.contains("line "), "{error}");
        }
        assert!(error(&["lidar.beems=181"]).contains("did you mean \"beams\"?"));
        assert!(error(&["script.kind=patroll"]).contains("did you mean \"patrol\"?"));
        let other = load("apartment", &["script.kind=figure-eight".to_owned()]).unwrap();
        assert!(matches!(other.scenario.script, ScriptConfig::FigureEight { .. }));
        let straight = ["script={kind=\"straight\"}", "script.v_m_s=0.25"].map(str::to_owned);
        let script = load("apartment", &straight).unwrap().scenario.script;
        assert_eq!(script, ScriptConfig::Straight { v_m_s: 0.25 });
    }
}
