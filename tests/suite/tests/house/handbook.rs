//! The handbook: its pages are linked, and its tables of fields are those of the
//! code.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use rusty_contract::Scenario;
use rusty_engine::scenario_file::{self, Loaded};
use rusty_geometry::WorldSpec;
use rusty_tests::{handbook_pages, repository};
use serde::de::DeserializeOwned;
use toml::{Table, Value};

use crate::read;

/// The text without fenced blocks.
fn prose(text: &str) -> String {
    text.split("```").step_by(2).collect()
}

/// The relative targets of a page's links.
fn links(text: &str) -> Vec<String> {
    let targets = prose(text);
    let targets = targets.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    targets.filter(|t| !t.contains("://")).map(str::to_owned).collect()
}

/// The anchors of a page's headings, as mdBook and GitHub make them.
fn anchors(text: &str) -> BTreeSet<String> {
    let headings = prose(text);
    let headings = headings.lines().filter(|l| l.starts_with('#'));
    let anchor = |line: &str| {
        let words = line.trim_start_matches('#').trim().to_lowercase();
        let kept = |c: &char| c.is_alphanumeric() || " -_".contains(*c);
        words.chars().filter(kept).map(|c| if c == ' ' { '-' } else { c }).collect()
    };
    headings.map(anchor).collect()
}

#[test]
fn every_link_of_readme_and_handbook_has_a_target() {
    let mut broken = Vec::new();
    for page in handbook_pages().into_iter().chain(["README.md".to_owned()]) {
        for link in links(&read(&page)) {
            let (file, anchor) = link.split_once('#').unwrap_or((&link, ""));
            let target = match file {
                "" => page.clone().into(),
                file => Path::new(&page).parent().unwrap().join(file),
            };
            let is_there = repository().join(&target).exists()
                && (anchor.is_empty() || anchors(&read(&target)).contains(anchor));
            if !is_there {
                broken.push(format!("{page}: {link}"));
            }
        }
    }
    assert!(broken.is_empty(), "links without a target: {broken:#?}");
    assert_eq!(anchors("## A `b`, c: D\n").first().unwrap(), "a-b-c-d");
}

#[test]
fn every_page_is_in_the_table_of_contents_once_and_the_readme_names_the_first() {
    let contents = links(&read("docs/SUMMARY.md"));
    let mut listed: Vec<String> = contents.iter().map(|name| format!("docs/{name}")).collect();
    listed.sort();
    let mut expected = handbook_pages();
    expected.retain(|page| page != "docs/SUMMARY.md");
    assert_eq!(listed, expected, "left: docs/SUMMARY.md, right: docs/");
    assert!(links(&read("README.md")).contains(&format!("docs/{}", contents[0])));
}

/// A row of a table of fields.
struct Row {
    field: String,
    kind: String,
    unit: String,
    range: String,
    default: String,
}

/// The rows of the tables under each heading of a page.
fn rows(page: &str) -> BTreeMap<String, Vec<Row>> {
    let mut found: BTreeMap<String, Vec<Row>> = BTreeMap::new();
    let mut heading = String::new();
    for line in read(page).lines() {
        if line.starts_with('#') {
            line.clone_into(&mut heading);
        }
        let cells: Vec<String> = line.split('|').map(|cell| cell.trim().replace('`', "")).collect();
        if let [_, field, kind, unit, range, default, _, _] = cells.as_slice()
            && line.starts_with("| `")
        {
            let [field, kind, unit, range, default] =
                [field, kind, unit, range, default].map(String::to_owned);
            let row = Row { field, kind, unit, range, default };
            found.entry(heading.clone()).or_default().push(row);
        }
    }
    found
}

/// A scenario with every table and list that a scenario can have.
fn base(script: &str) -> Table {
    let mut base = Table::try_from(Scenario::default()).unwrap();
    let more: Table = toml::from_str(&format!(
        "kidnapping = [{{ tick = 5, to = {{ x_m = 0.0, y_m = 0.0, theta_rad = 0.0 }} }}]\n\
         walker = [{{ waypoints = [[1.0, 1.0]] }}]\n\
         crowd = {{ people = 2 }}\n\
         patch = [{{ corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], slip_std = 0.0 }}]\n\
         participant = [{{ name = \"a\", compute = {{ scan_s = 0.0 }} }}]\n\
         script = {{ kind = \"{script}\" }}\n\
         [sensors]\nbumper = {{}}\nimu = {{}}\ndoors = {{}}\nlandmarks = {{}}\n\
         sonar = {{ mounts = [{{ x_m = 0.0, y_m = 0.0, theta_rad = 0.0 }}] }}"
    ))
    .unwrap();
    base.extend(more);
    match script {
        "straight" => put(&mut base, "script.v_m_s", Some(Value::Float(0.5))),
        "driver" => put(&mut base, "participant.role", Some("driver".into())),
        "commands" => {
            let twist = Table::from_iter(["v_m_s", "omega_rad_s"].map(|k| (k.into(), 0.0.into())));
            put(&mut base, "script.list", Some(vec![twist].into()));
        }
        _ => {}
    }
    base
}

/// Sets or removes the field at a path; of a list, that of its first element.
fn put(table: &mut Table, path: &str, value: Option<Value>) {
    let mut place = table;
    let mut parts = path.split('.').peekable();
    while let Some(part) = parts.next() {
        if parts.peek().is_none() {
            match value {
                Some(value) => place.insert(part.to_owned(), value),
                None => place.remove(part),
            };
            return;
        }
        let empty = || Value::Table(Table::new());
        place = match place.entry(part.to_owned()).or_insert_with(empty) {
            Value::Array(list) => list[0].as_table_mut().unwrap(),
            inner => inner.as_table_mut().unwrap(),
        };
    }
}

/// The scenario of a table, if every field can be used.
fn scenario(table: &Table) -> Result<Scenario, String> {
    let text = toml::to_string(table).map_err(|e| e.to_string())?;
    let scenario = scenario_file::read(&text, &[]).map_err(|e| e.to_string())?;
    let loaded = Loaded { scenario, folder: PathBuf::new() };
    loaded.config().map_err(|e| e.to_string())?;
    Ok(loaded.scenario)
}

/// The scenario with another value at a path.
fn with(base: &Table, path: &str, value: Option<Value>) -> Result<Scenario, String> {
    let mut table = base.clone();
    put(&mut table, path, value);
    scenario(&table)
}

/// The words that the parser lists where it found the unknown field or variant
/// `zzz`.
fn expected<T: DeserializeOwned>(table: Table, what: &str) -> Option<BTreeSet<String>> {
    let error = table.try_into::<T>().err()?;
    let message = error.message();
    if !message.contains(&format!("unknown {what} `zzz`")) {
        return None;
    }
    let (_, words) = message.split_once(", expected ").unwrap_or((message, ""));
    Some(words.split('`').skip(1).step_by(2).map(str::to_owned).collect())
}

/// The paths of all fields that the parser takes in the table or list at `path`;
/// `None` if there is neither.
fn fields<T: DeserializeOwned>(base: &Table, path: &str) -> Option<BTreeSet<String>> {
    let mut probe = if path.is_empty() { base.clone() } else { Table::new() };
    if path == "script" {
        probe.insert("kind".into(), base["script"]["kind"].clone());
    }
    probe.insert("zzz".into(), true.into());
    let at_path = |value: Value| {
        let mut table = base.clone();
        put(&mut table, path, Some(value));
        expected::<T>(table, "field")
    };
    let names = match path {
        "" => expected::<T>(probe, "field"),
        _ => at_path(probe.clone().into()).or_else(|| at_path(vec![probe].into())),
    };
    let inside = |name: String| {
        let inner = if path.is_empty() { name } else { format!("{path}.{name}") };
        match inner.as_str() {
            // Its kind decides which fields it has.
            "event" => [inner].into(),
            _ => fields::<T>(base, &inner).unwrap_or_else(|| [inner].into()),
        }
    };
    Some(names?.into_iter().flat_map(inside).collect())
}

/// A number of the page: `0.02`, `2^40`, `-2π`, `1e-6`.
fn number(text: &str) -> f64 {
    let (sign, text) = text.strip_prefix('-').map_or((1.0, text), |rest| (-1.0, rest));
    let size = match (text.strip_suffix('π'), text.split_once('^')) {
        (Some(""), _) => std::f64::consts::PI,
        (Some(factor), _) => factor.parse::<f64>().unwrap() * std::f64::consts::PI,
        (_, Some((base, power))) => {
            base.parse::<f64>().unwrap().powi(power.parse::<i32>().unwrap())
        }
        _ => text.parse().unwrap_or_else(|e| panic!("{text}: {e}")),
    };
    sign * size
}

/// The unit that the name of a field states.
fn unit_of(field: &str) -> &'static str {
    let units = [
        ("_deg_sqrt_h", "°/√h"),
        ("_deg_h", "°/h"),
        ("_ug_sqrt_hz", "µg/√Hz"),
        ("_ug", "µg"),
        ("_per_m", "m/m"),
        ("_m_s", "m/s"),
        ("_rad_s", "rad/s"),
        ("_rad", "rad"),
        ("_m", "m"),
        ("_s", "s"),
    ];
    units.iter().find(|(end, _)| field.ends_with(end)).map_or("", |(_, unit)| unit)
}

/// Checks type and range of a row by values inside and outside.
fn check_values(base: &Table, row: &Row) {
    let Row { field, kind, range, .. } = row;
    let refused = |value: Value| {
        let said = format!("{field} = {value} can be used; the page: {kind}, {range}");
        with(base, field, Some(value)).expect_err(&said);
    };
    let taken = |value: Value| {
        let said = format!("{field} = {value}; the page: {kind}, {range}");
        with(base, field, Some(value)).unwrap_or_else(|e| panic!("{said}: {e}"));
    };
    let whole = kind == "integer";
    let value = |x: f64| if whole { Value::Integer(x as i64) } else { Value::Float(x) };
    match kind.as_str() {
        "integer" | "number" => {
            refused("zzz".into());
            if whole {
                refused(Value::Float(1.5));
            } else {
                refused(Value::Float(f64::NAN));
            }
            if range == "any" {
                return taken(value(1e4));
            }
            if range == "0 or more" {
                refused(value(-1.0));
                return taken(Value::Integer(i64::MAX));
            }
            let (low, high) =
                range.split_once(" to ").unwrap_or_else(|| panic!("{field}: {range}"));
            let [low, high] = [low, high].map(number);
            let step = |x: f64| if whole { 1.0 } else { 1e-6 * x.abs().max(1.0) };
            taken(value(low));
            refused(value(low - step(low)));
            taken(value(high));
            refused(value(high + step(high)));
        }
        "word" => {
            let mut probed = base.clone();
            put(&mut probed, field, Some("zzz".into()));
            let listed: BTreeSet<String> = range.split(", ").map(str::to_owned).collect();
            if let Some(words) = expected::<Scenario>(probed, "variant") {
                assert_eq!(listed, words, "{field}: left: the page, right: the code");
            }
            refused("zzz".into());
            for word in listed {
                let mut table = base.clone();
                put(&mut table, field, Some(Value::String(word.clone())));
                if field == "script.kind" {
                    table = self::base(&word);
                }
                let read = table.try_into::<Scenario>();
                read.unwrap_or_else(|e| panic!("{field} = {word}: {e}"));
            }
        }
        "flag" => refused("zzz".into()),
        "text" => refused(Value::Integer(1)),
        "list of texts" | "list of points" | "list of events" => {
            refused(vec![Value::Integer(1)].into());
        }
        other => panic!("{field}: type {other}"),
    }
}

/// Checks that a scenario without the field is one with its default.
fn check_default(base: &Table, row: &Row) {
    let Row { field, default, .. } = row;
    // A pose is given as a whole or not at all.
    let without = with(base, field, None).or_else(|e| match field.rsplit_once('.') {
        Some((pose @ ("start" | "lidar.sensor_in_body"), _)) => with(base, pose, None),
        _ => Err(e),
    });
    match default.as_str() {
        "required" => {
            without.expect_err(&format!("{field} is not required"));
        }
        "unset" => {
            without.unwrap_or_else(|e| panic!("{field}: {e}"));
        }
        default => {
            let value = toml::from_str::<Table>(&format!("v = {}", number_or(default)))
                .unwrap_or_else(|e| panic!("{field}: {e}"));
            let set = with(base, field, Some(value["v"].clone()));
            assert_eq!(without, set, "{field}: left: absent, right: {default}");
        }
    }
}

/// A default as TOML writes it.
fn number_or(default: &str) -> String {
    let is_toml = toml::from_str::<Table>(&format!("v = {default}")).is_ok();
    match default {
        _ if is_toml => default.to_owned(),
        multiple if multiple.ends_with('π') => number(multiple).to_string(),
        word => format!("{word:?}"),
    }
}

#[test]
fn the_reference_of_scenarios_has_every_field_with_its_type_range_and_default() {
    let all = rows("docs/scenarios.md");
    let mut unknown = base("driver");
    put(&mut unknown, "script.kind", Some("zzz".into()));
    let kinds = expected::<Scenario>(unknown, "variant").unwrap();
    for kind in kinds {
        let base = base(&kind);
        scenario(&base).unwrap_or_else(|e| panic!("{kind}: {e}"));
        let of_kind = |heading: &&String| {
            !heading.starts_with("### Script") || heading.contains(&format!("`{kind}`"))
        };
        let sections: Vec<&String> = all.keys().filter(of_kind).collect();
        let rows: Vec<&Row> = sections.iter().flat_map(|heading| &all[*heading]).collect();
        let mut written: BTreeSet<String> = rows.iter().map(|row| row.field.clone()).collect();
        assert_eq!(written.len(), rows.len(), "{kind}: a field has two rows");
        // The kind itself is no field of the variant that the parser lists.
        assert!(written.remove("script.kind"), "script.kind has no row");
        let real = fields::<Scenario>(&base, "").unwrap();
        assert_eq!(written, real, "script {kind}: left: docs/scenarios.md, right: the code");
        for row in rows {
            assert_eq!(row.unit, unit_of(&row.field), "{}: unit", row.field);
            check_values(&base, row);
            check_default(&base, row);
        }
    }
}

#[test]
fn the_page_of_world_files_has_every_key_and_an_example_that_can_be_used() {
    let page = read("docs/worlds.md");
    let (_, example) = page.split_once("```toml\n").unwrap();
    let spec = WorldSpec::from_toml_str(example.split("```").next().unwrap()).unwrap();
    spec.check().unwrap();
    let base = Table::try_from(&spec).unwrap();
    let keys = page.lines().filter_map(|line| line.strip_prefix("| `")?.split('`').next());
    let written: BTreeSet<String> = keys.map(str::to_owned).collect();
    let mut real = fields::<WorldSpec>(&base, "").unwrap();
    real.extend(["walls", "landmarks"].map(str::to_owned));
    assert_eq!(written, real, "left: docs/worlds.md, right: the code");
}

/// The fenced blocks of a language on a page.
fn blocks(page: &str, language: &str) -> Vec<String> {
    let (page, fence) = (read(page), format!("```{language}\n"));
    let blocks = page.split(&fence).skip(1);
    blocks.map(|block| block.split("```").next().unwrap().to_owned()).collect()
}

#[test]
fn the_tutorials_have_the_code_of_the_readme() {
    for (page, language) in
        [("docs/first-filter-rust.md", "rust"), ("docs/first-filter-python.md", "python")]
    {
        let code = blocks(page, language);
        assert!(!code.is_empty() && code == blocks("README.md", language), "{page}");
    }
}
