//! The manifest of a sweep in shards: the file that all its machines share.
//!
//! It has the options of the sweep, the settings that result from them, the number of
//! shards, and the digests of the golden runs on the machine that planned it. A machine
//! makes a shard only if its settings and its golden runs are the same.

use std::collections::BTreeMap;
use std::path::Path;

use rusty_contract::{FieldError, input, replace};
use rusty_sim::GOLDENS;
use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::xxh3_128;

use super::error::SweepError;
use super::grid::{Axis, axes};
use super::part::Part;
use super::plan::{Plan, Request};
use super::settings::Settings;
use super::shard::Shard;

const CHANGED: &str = "plan the sweep again with `sim-server sweep plan`";

/// The plan of a sweep in shards, as it is in a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// Digest of all other fields, 32 hexadecimal digits.
    pub digest: String,
    /// Number of shards.
    pub shards: u64,
    /// Number of runs of all shards.
    pub runs: u64,
    /// A scenario file, or a built-in one.
    pub scenario: String,
    /// Seeds, as in `--seeds`.
    pub seeds: String,
    /// The swept fields, as in `--set`.
    pub set: Vec<String>,
    /// The field whose two values are compared, as in `--ab`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ab: Option<String>,
    /// Number of ticks, if not the scenario's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ticks: Option<u64>,
    /// Whether runs are complete launches with clients.
    pub clients: bool,
    /// Estimators that take part in every run, as in `--add`.
    pub add: Vec<String>,
    /// The [`Settings`] of the whole sweep, as JSON.
    pub settings: String,
    /// Digests of the golden runs, by name.
    pub goldens: BTreeMap<String, String>,
}

impl Manifest {
    /// Returns the manifest of a sweep in `shards` shards, made by `writer`. With
    /// `compared`, the last axis is that of `--ab`.
    ///
    /// # Errors
    /// [`SweepError`] if there are fewer runs than shards, or this build computes other
    /// bits than it should.
    pub fn of(plan: &Plan, compared: bool, shards: u64, writer: &str) -> Result<Self, SweepError> {
        let runs = plan.count();
        if shards == 0 || shards > runs {
            let remedy = format!("give 1 to {runs}: there are {runs} runs");
            return Err(FieldError::new("--shards", shards, "is out of range", remedy).into());
        }
        let goldens = goldens()?;
        let expected = GOLDENS.iter().map(|g| (g.name.to_owned(), g.expected.to_owned()));
        check_same(&expected.collect(), &goldens)?;
        let Request { scenario, seeds, axes, ticks, clients, add } = plan.request.clone();
        let mut set: Vec<String> = axes.iter().map(Axis::to_string).collect();
        let manifest = Self {
            digest: String::new(),
            shards,
            runs,
            scenario,
            seeds: seeds.to_string(),
            ab: if compared { set.pop() } else { None },
            set,
            ticks,
            clients,
            add,
            settings: Settings::of(plan, writer)?.text(),
            goldens,
        };
        Ok(manifest.sealed())
    }

    /// Returns it with the digest that belongs to its other fields.
    #[must_use]
    pub fn sealed(self) -> Self {
        let unsealed = Self { digest: String::new(), ..self };
        let text = toml::to_string(&unsealed).unwrap_or_default();
        Self { digest: format!("{:032x}", xxh3_128(text.as_bytes())), ..unsealed }
    }

    /// Reads a manifest.
    ///
    /// # Errors
    /// [`SweepError::Manifest`] if the file is not a manifest, or was changed.
    pub fn read(path: &Path) -> Result<Self, SweepError> {
        let wrong = |problem: String| SweepError::Manifest {
            path: path.display().to_string(),
            problem,
            remedy: CHANGED,
        };
        let bytes = input::read(path).map_err(SweepError::io(path))?;
        let text = String::from_utf8(bytes).map_err(|e| wrong(format!("is not a text: {e}")))?;
        let manifest: Self = toml::from_str(&text)
            .map_err(|e| wrong(format!("is not the manifest of a sweep: {}", e.message())))?;
        let expected = manifest.clone().sealed().digest;
        if manifest.digest != expected {
            let found = &manifest.digest;
            return Err(wrong(format!(
                "was changed: its digest is {expected}, and it has {found}"
            )));
        }
        Ok(manifest)
    }

    /// Writes it, whole or not at all.
    ///
    /// # Errors
    /// [`SweepError`] if the disk says no, or a number is too large for TOML.
    pub fn write(&self, path: &Path) -> Result<(), SweepError> {
        let text = toml::to_string(self).map_err(|e| SweepError::Manifest {
            path: path.display().to_string(),
            problem: format!("cannot be written: {e}"),
            remedy: "use numbers below 2^63",
        })?;
        let head = "# A sweep in shards, for `sim-server sweep run` and `sim-server sweep merge`.\n\
                    # A change makes its digest wrong: plan again with `sim-server sweep plan`.\n";
        replace(path, format!("{head}{text}").as_bytes()).map_err(SweepError::io(path))
    }

    /// Returns the plan of the whole sweep on this machine, and its settings as `writer`
    /// writes them.
    ///
    /// # Errors
    /// [`SweepError`] if they are not those of the manifest.
    pub fn plan(&self, writer: &str) -> Result<(Plan, Settings), SweepError> {
        let plan = Plan::new(Request {
            scenario: self.scenario.clone(),
            seeds: self
                .seeds
                .parse()
                .map_err(|why: String| FieldError::new("seeds", &self.seeds, why, CHANGED))?,
            axes: axes(&self.set, self.ab.as_deref())?,
            ticks: self.ticks,
            clients: self.clients,
            add: self.add.clone(),
        })?;
        let here = Settings::of(&plan, writer)?;
        let there = Settings::read(self.settings.as_bytes()).unwrap_or_default();
        match there.difference(&here) {
            None => Ok((plan, here)),
            Some(difference) => Err(SweepError::OtherSettings { difference }),
        }
    }

    /// Simulates the golden runs and compares their digests.
    ///
    /// # Errors
    /// [`SweepError::OtherBits`] names the first golden run that differs.
    pub fn check_goldens(&self) -> Result<(), SweepError> {
        check_same(&self.goldens, &goldens()?)
    }

    /// Returns the part of shard `index` in `folder`.
    ///
    /// # Errors
    /// [`FieldError`] if there is no such shard.
    pub fn part(&self, folder: &Path, index: u64) -> Result<Part, FieldError> {
        let count = self.shards;
        if index >= count {
            let remedy = format!("give 0 to {}", count - 1);
            return Err(FieldError::new("--shard", index, "is out of range", remedy));
        }
        Ok(Part::new(folder, &self.digest, Shard { index, count }, self.runs))
    }
}

/// Simulates the golden runs. Returns their digests by name.
fn goldens() -> Result<BTreeMap<String, String>, SweepError> {
    GOLDENS.iter().map(|golden| Ok((golden.name.to_owned(), golden.found()?))).collect()
}

fn check_same(
    expected: &BTreeMap<String, String>,
    found: &BTreeMap<String, String>,
) -> Result<(), SweepError> {
    let mut names = expected.keys().chain(found.keys());
    let Some(name) = names.find(|name| expected.get(*name) != found.get(*name)) else {
        return Ok(());
    };
    let digest = |of: &BTreeMap<String, String>| {
        of.get(name).map_or_else(|| "no such run".to_owned(), String::clone)
    };
    Err(SweepError::OtherBits {
        name: name.clone(),
        expected: digest(expected),
        found: digest(found),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn manifest(shards: u64) -> Result<Manifest, SweepError> {
        let set = [
            "start={ x_m = 6.0, y_m = 4.5, theta_rad = 0.0 },{ x_m = 5.0, y_m = 4.5, theta_rad = 0.0 }",
        ];
        let plan = Plan::new(Request {
            scenario: "patrol".to_owned(),
            seeds: "3..8".parse().unwrap(),
            axes: axes(&set.map(str::to_owned), Some("robot.slip_std=0.01,0.02")).unwrap(),
            ticks: Some(7),
            clients: false,
            add: Vec::new(),
        })?;
        Manifest::of(&plan, true, shards, "test")
    }

    #[test]
    fn a_manifest_reads_back_and_plans_the_same_runs() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("m.toml");
        let made = manifest(3).unwrap();
        made.write(&path).unwrap();
        let read = Manifest::read(&path).unwrap();
        assert_eq!(
            (&read, read.runs, read.ab.as_deref()),
            (&made, 20, Some("robot.slip_std=0.01,0.02"))
        );
        let (plan, _) = read.plan("test").unwrap();
        assert_eq!((plan.cells.len(), plan.runs), (4, 0..20));
        // The same options give the same manifest, and another number of shards another.
        assert_eq!(manifest(3).unwrap().digest, made.digest);
        assert_ne!(manifest(4).unwrap().digest, made.digest);
        assert!(matches!(manifest(21), Err(SweepError::Run(_))));
        let error = read.plan("other").err().unwrap().to_string();
        assert!(error.contains("writer: \"test\" and \"other\""), "{error}");
        read.part(place.path(), 2).unwrap();
        assert!(read.part(place.path(), 3).is_err());
    }

    #[test]
    fn a_changed_manifest_is_refused() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("m.toml");
        manifest(3).unwrap().write(&path).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        for (from, to) in
            [("3..8", "3..9"), ("shards = 3", "shards = 2"), ("ticks = 7", "ticks = 8")]
        {
            std::fs::write(&path, text.replacen(from, to, 1)).unwrap();
            let error = Manifest::read(&path).unwrap_err();
            assert!(matches!(error, SweepError::Manifest { .. }), "{error}");
        }
        std::fs::write(&path, text.replace("clients", "client")).unwrap();
        let error = Manifest::read(&path).unwrap_err().to_string();
        assert!(error.contains("sweep plan"), "{error}");
    }

    #[test]
    fn a_golden_run_that_differs_or_is_not_there_is_named() {
        let mut made = manifest(2).unwrap();
        made.check_goldens().unwrap();
        let (name, digest) = made.goldens.pop_first().unwrap();
        let error = made.check_goldens().unwrap_err().to_string();
        assert!(error.contains(&name) && error.contains("no such run"), "{error}");
        made.goldens.insert(name.clone(), digest.replace(|c: char| c.is_ascii_digit(), "f"));
        let error = made.check_goldens().unwrap_err();
        assert_eq!(error.exit(), rusty_contract::Exit::NotBitExact);
        let text = error.to_string();
        assert!(
            text.contains(&name) && text.contains(&digest) && text.contains("doctor"),
            "{text}"
        );
    }
}
