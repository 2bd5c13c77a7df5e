//! Changes of the form `robot.slip_std=0.05`: the option `--set`.

use rusty_contract::scenario::ScenarioError;
use rusty_contract::suggest::for_message;
use rusty_contract::{FieldError, RunConfig, Scenario};

/// The most parts of a `--set` key; no field lies deeper.
const MAX_KEY_PARTS: usize = 16;

/// Applies `key=value` changes to the text of a scenario.
///
/// # Errors
/// [`ScenarioError`] names the change that cannot be made, or the first field
/// that cannot be used.
pub(super) fn change(text: &str, changes: &[String]) -> Result<Scenario, ScenarioError> {
    let syntax = |e: toml::de::Error| ScenarioError::Syntax(e.to_string().trim_end().to_owned());
    let mut table: toml::Table = toml::from_str(text).map_err(syntax)?;
    let mut scenario = Scenario::default();
    // The change to blame, and what is wrong. A later change may complete an
    // earlier one: `script.kind`, then `script.v_m_s`.
    let mut wrong: Option<(&String, toml::de::Error)> = None;
    let mut large_seed = None;
    for change in changes {
        match seed_of(change) {
            Some(Some(seed)) => large_seed = Some(seed),
            small => {
                large_seed = if small.is_some() { None } else { large_seed };
                insert(&mut table, change)?;
            }
        }
        match table.clone().try_into() {
            Ok(read) => (scenario, wrong) = (read, None),
            Err(e) => match &wrong {
                Some((_, before)) if before.message() == e.message() => {}
                _ => wrong = Some((change, e)),
            },
        }
    }
    if let Some((change, error)) = wrong {
        return Err(value_error(change, error.message()).into());
    }
    scenario.seed = large_seed.unwrap_or(scenario.seed);
    scenario.check()?;
    Ok(scenario)
}

/// Returns whether a change sets the seed, and the seed if it has no room in the
/// integers of TOML, which have a sign.
fn seed_of(change: &str) -> Option<Option<u64>> {
    let (_, value) = change.split_once('=').filter(|(key, _)| key.trim() == "seed")?;
    Some(value.trim().parse().ok().filter(|seed| i64::try_from(*seed).is_err()))
}

/// Sets one field in the table of a scenario.
fn insert(table: &mut toml::Table, change: &str) -> Result<(), FieldError> {
    let (key, value) = parse_change(change)?;
    // Whoever walks through tables in tables needs stack for each.
    if key.split('.').count() > MAX_KEY_PARTS {
        return Err(change_error(change, "names a field that no scenario has"));
    }
    let mut place = table;
    let mut parts = key.trim().split('.').peekable();
    while let Some(part) = parts.next() {
        if parts.peek().is_none() {
            if part == "kind" && place.get(part).is_some_and(|kind| *kind != value) {
                // The other fields are parameters of the kind that was there.
                place.clear();
            }
            place.insert(part.to_owned(), value);
            break;
        }
        let next =
            place.entry(part.to_owned()).or_insert_with(|| toml::Value::Table(toml::Table::new()));
        let through = || change_error(change, "goes through a value");
        place = next.as_table_mut().ok_or_else(through)?;
    }
    Ok(())
}

/// The error of a change whose field or value a parser does not take.
fn value_error(change: &str, message: &str) -> FieldError {
    let mut remedy = for_message(message).trim_start_matches("; ").to_owned();
    if remedy.is_empty() {
        "give a field and a value that it takes".clone_into(&mut remedy);
    }
    FieldError::new("--set", change, message, remedy)
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
        if let Some(Some(seed)) = seed_of(change) {
            config.seed = seed;
            continue;
        }
        let error = |e: serde_json::Error| value_error(change, &e.to_string());
        let (key, value) = parse_change(change)?;
        // JSON, because TOML has no room for a seed of 64 bits.
        let mut whole = serde_json::to_value(&config).map_err(error)?;
        let mut place = &mut whole;
        for part in key.trim().split('.') {
            let inside = place.as_object_mut();
            place = inside
                .ok_or_else(|| change_error(change, "goes through a value"))?
                .entry(part)
                .or_insert(serde_json::Value::Null);
        }
        *place = serde_json::to_value(value).map_err(error)?;
        config = serde_json::from_value(whole).map_err(error)?;
    }
    Ok(config)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario_file::load;
    use rusty_contract::ScriptConfig;

    #[test]
    fn a_seed_may_have_64_bits() {
        let seed = |changes: &[&str]| {
            let changes: Vec<String> = changes.iter().map(|&c| c.to_owned()).collect();
            load("apartment", &changes).unwrap().scenario.seed
        };
        assert_eq!(seed(&["seed=18446744073709551615", "ticks=5"]), u64::MAX);
        assert_eq!(seed(&["ticks=5", "seed=9223372036854775808"]), 1 << 63);
        assert_eq!(seed(&["seed=18446744073709551615", "seed = 7"]), 7);
        let config = load("apartment", &[]).unwrap().config().unwrap();
        let change = |text: &str| change_config(&config, &[text.to_owned()]).unwrap().seed;
        assert_eq!((change("seed = 18446744073709551615"), change("seed=7")), (u64::MAX, 7));
        assert!(load("apartment", &["seed=18446744073709551616".to_owned()]).is_err());
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
