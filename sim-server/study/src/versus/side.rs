//! A and B: which estimator of which table, and which settings they share.

use serde_json::Value;

use super::contents::Contents;
use super::error::VersusError;
use crate::documents;

/// An estimator of a table.
#[derive(Clone, Copy, Debug)]
pub struct Side<'c> {
    /// The table.
    pub contents: &'c Contents,
    /// Index of the name.
    pub estimator: usize,
}

impl Side<'_> {
    /// The estimator's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.contents.estimators[self.estimator]
    }
}

/// A and B of one table, or of two, by the names that were given. Where none
/// is, there must be no choice: one estimator in the table, or two if it is the
/// only table; of a second table also A's, if it has it.
///
/// # Errors
/// [`VersusError`] lists the names that there are.
pub fn sides<'c>(
    table: &'c Contents,
    other: Option<&'c Contents>,
    [a, b]: [Option<&str>; 2],
) -> Result<[Side<'c>; 2], VersusError> {
    let second = other.unwrap_or(table);
    let named = |of: &'c Contents, name: &str, option| match place(of, name) {
        Some(estimator) => Ok(Side { contents: of, estimator }),
        None => Err(who(of, format!("has no estimator {name:?}"), option)),
    };
    // The one that is left when the other is known.
    let rest = |known: Option<&str>| {
        let mut left = (0..table.estimators.len()).filter(|i| known != Some(&table.estimators[*i]));
        (other.is_none() && table.estimators.len() == 2).then(|| left.next()).flatten()
    };
    let several = |of: &Contents| format!("has {} estimators", of.estimators.len());
    let side_a = match a {
        Some(name) => named(table, name, "--a")?,
        None => match rest(b).or((table.estimators.len() == 1).then_some(0)) {
            Some(estimator) => Side { contents: table, estimator },
            None => return Err(who(table, several(table), "--a")),
        },
    };
    let only = |of: &Contents| (of.estimators.len() == 1).then_some(0);
    let side_b = match b {
        Some(name) => named(second, name, "--b")?,
        None => {
            let same = other.and_then(|of| place(of, side_a.name()));
            match rest(Some(side_a.name())).or(same).or(only(second)) {
                Some(estimator) => Side { contents: second, estimator },
                None => return Err(who(second, several(second), "--b")),
            }
        }
    };
    if other.is_none() && side_a.estimator == side_b.estimator {
        let (name, path) = (side_a.name().to_owned(), table.path.clone());
        let remedy = match table.estimators.len() {
            1 => "the table has no other; sweep with `--clients --add NAME=COMMAND`",
            _ => "name another with --b NAME",
        };
        return Err(VersusError::Same { name, path, remedy });
    }
    Ok([side_a, side_b])
}

fn place(of: &Contents, name: &str) -> Option<usize> {
    of.estimators.iter().position(|n| n == name)
}

fn who(of: &Contents, problem: String, option: &'static str) -> VersusError {
    VersusError::Who { path: of.path.clone(), problem, names: of.names(), option }
}

/// The settings that both have, as indices, each at most once: of one table its
/// own; of two those of equal words and, where both tell their configurations,
/// equal ones, whatever they are called, if there is but one such on either side.
///
/// # Errors
/// [`VersusError::Settings`] names the first field that differs, if none are.
pub fn shared_settings(a: &Contents, b: &Contents) -> Result<Vec<[usize; 2]>, VersusError> {
    if std::ptr::eq(a, b) {
        return Ok((0..a.settings.len()).map(|i| [i, i]).collect());
    }
    let config = |of: &Contents, setting: &str| {
        let all = of.configs.as_ref()?;
        all.iter().find(|(words, _)| words == setting).map(|(_, config)| config.clone())
    };
    let is_same = |i: usize, j: usize| {
        let (ours, theirs) = (&a.settings[i], &b.settings[j]);
        match (config(a, ours), config(b, theirs)) {
            (Some(x), Some(y)) => x == y,
            _ => ours == theirs,
        }
    };
    let all = |of: &Contents| 0..of.settings.len();
    let only = |mut found: Box<dyn Iterator<Item = usize> + '_>| {
        let first = found.next()?;
        found.next().is_none().then_some(first)
    };
    let pair = |i: usize| {
        let named = all(b).find(|&j| a.settings[i] == b.settings[j] && is_same(i, j));
        let alike = || {
            let j = only(Box::new(all(b).filter(|&j| is_same(i, j))))?;
            only(Box::new(all(a).filter(|&k| is_same(k, j)))).map(|_| j)
        };
        Some([i, named.or_else(alike)?])
    };
    let pairs: Vec<[usize; 2]> = all(a).filter_map(pair).collect();
    if !pairs.is_empty() {
        return Ok(pairs);
    }
    let first = |of: &Contents| of.settings.first().and_then(|s| config(of, s));
    let difference = match (first(a), first(b)) {
        (Some(a), Some(b)) => difference(&a, &b),
        _ => format!("{:?} and {:?}", a.settings.join(", "), b.settings.join(", ")),
    };
    Err(VersusError::Settings { a: a.path.clone(), b: b.path.clone(), difference })
}

fn difference(a: &Value, b: &Value) -> String {
    let same = "several settings have the same configuration, and other words for it";
    documents::differences(a, b).into_iter().next().unwrap_or_else(|| same.to_owned())
}
