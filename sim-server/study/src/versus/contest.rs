//! Pairs of runs, and what they say, metric by metric.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;

use super::contents::Run;
use super::error::VersusError;
use super::metric::Metric;
use super::side::{Side, shared_settings};
use rusty_metrics::Paired;

/// What comparing A with B came to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Versus {
    /// Name of A in its table.
    pub a: Who,
    /// Name of B in its table.
    pub b: Who,
    /// Probability of the intervals.
    pub level: f64,
    /// Each setting that both have, by itself.
    pub settings: Vec<Contest>,
    /// What else should be known.
    pub remarks: Vec<String>,
}

/// An estimator and where it stands.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Who {
    /// Name in the roster.
    pub name: String,
    /// The table.
    pub table: String,
}

/// The runs of one setting.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Contest {
    /// What is set, in words; empty where nothing was swept.
    pub setting: String,
    /// Seeds that both have.
    pub seeds: usize,
    /// Seeds that B lacks, and that A lacks.
    pub alone: [Vec<u64>; 2],
    /// Seeds left out because one of the two runs ended earlier.
    pub cut_short: Vec<u64>,
    /// Metric by metric.
    pub outcomes: Vec<Outcome>,
}

/// What the pairs say in one metric.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Outcome {
    /// Which; less is better.
    pub metric: Metric,
    /// Its unit.
    pub unit: &'static str,
    /// What the pairs are of, in the plural: seeds, as a rule.
    #[serde(skip)]
    pub samples: &'static str,
    /// B − A over the seeds that both have.
    #[serde(flatten)]
    pub paired: Paired,
    /// The figures of A and B by seed.
    #[serde(skip)]
    pub figures: BTreeMap<u64, [Option<f64>; 2]>,
    /// Interval of the mean difference (Student's t); null with one pair.
    pub interval: [f64; 2],
    /// The difference in per cent of A's mean.
    pub effect_percent: f64,
    /// Seeds in which A has less, and in which B has.
    pub wins: [u64; 2],
    /// Seeds in which they are equal to the bit.
    pub ties: u64,
    /// Of the wins, those in which the other never came to it: only times until
    /// something happens can be without end.
    pub one_sided: [u64; 2],
    /// Probability of wins as uneven if neither is better (sign test, exact).
    pub sign_p: f64,
    /// Who is better, if the interval does not hold 0.
    pub better: Option<Better>,
    /// All of it in a sentence.
    pub verdict: String,
}

/// Who is better.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Better {
    /// A.
    A,
    /// B.
    B,
}

/// Compares A with B on the seeds that both have. Metrics of which neither has
/// a single figure are left out unless they are `asked` for.
///
/// # Errors
/// [`VersusError`] if they share no run, did not drive the same ones, or no
/// metric has two pairs.
pub fn versus(
    [a, b]: [Side<'_>; 2],
    metrics: &[Metric],
    asked: bool,
    level: f64,
) -> Result<Versus, VersusError> {
    let mut contests = Vec::new();
    for [of_a, of_b] in shared_settings(a.contents, b.contents)? {
        let met = Met::of(&a, &b, [of_a, of_b])?;
        contests.push(met.contest(metrics, asked, level, [a.name(), b.name()]));
    }
    let who = |s: &Side<'_>| Who { name: s.name().to_owned(), table: s.contents.path.clone() };
    if contests.iter().all(|c| c.seeds == 0) {
        let (a, b) = (a.contents.path.clone(), b.contents.path.clone());
        return Err(VersusError::NoPair { a, b });
    }
    if contests
        .iter()
        .flat_map(|c| &c.outcomes)
        .all(|o| o.paired.pairs < 2 && o.one_sided == [0, 0])
    {
        let words: Vec<String> = metrics.iter().map(|m| m.word()).collect();
        return Err(VersusError::OnePair { metrics: words.join(", ") });
    }
    let remarks = remarks(&a, &b, &contests, level);
    Ok(Versus { a: who(&a), b: who(&b), level, settings: contests, remarks })
}

fn remarks(a: &Side<'_>, b: &Side<'_>, contests: &[Contest], level: f64) -> Vec<String> {
    let mut remarks = Vec::new();
    for side in [a, b] {
        if side.contents.configs.is_none() && a.contents.path != b.contents.path {
            remarks.push(format!(
                "{} has no settings beside it ({}.json): only ticks and distances were compared",
                side.contents.path, side.contents.path
            ));
        }
        let others = side.contents.settings.len().saturating_sub(contests.len());
        if others > 0 {
            remarks
                .push(format!("{} has {others} settings that are not in both", side.contents.path));
        }
    }
    let most = contests.iter().map(|c| c.outcomes.len()).max().unwrap_or(0);
    if most * contests.len() > 1 {
        let by_chance = 1.0 / (1.0 - level);
        remarks.push(format!(
            "metrics of the same runs, and settings on the same seeds, are no independent tests; \
             where there is no difference, about one verdict in {by_chance:.0} says there is one"
        ));
    }
    remarks
}

/// The runs of a setting, by seed.
struct Met<'c> {
    setting: String,
    pairs: Vec<(u64, [&'c Run; 2])>,
    alone: [Vec<u64>; 2],
    cut_short: Vec<u64>,
}

impl<'c> Met<'c> {
    fn of(a: &Side<'c>, b: &Side<'c>, settings: [usize; 2]) -> Result<Self, VersusError> {
        let runs = |side: &Side<'c>, setting: usize| -> BTreeMap<u64, &'c Run> {
            let own = side.contents.runs.iter();
            let own = own.filter(|r| r.estimator == side.estimator && r.setting == setting);
            own.map(|r| (r.seed, r)).collect()
        };
        let (of_a, of_b) = (runs(a, settings[0]), runs(b, settings[1]));
        let without = |own: &BTreeMap<u64, &Run>, other: &BTreeMap<u64, &Run>| {
            own.keys().filter(|seed| !other.contains_key(seed)).copied().collect()
        };
        let mut met = Self {
            setting: a.contents.settings[settings[0]].clone(),
            pairs: Vec::new(),
            alone: [without(&of_a, &of_b), without(&of_b, &of_a)],
            cut_short: Vec::new(),
        };
        for (seed, a) in of_a {
            let Some(b) = of_b.get(&seed) else { continue };
            let known = a.distance_m.is_finite() && b.distance_m.is_finite();
            if a.ticks != b.ticks {
                met.cut_short.push(seed);
            } else if known && a.distance_m.to_bits() != b.distance_m.to_bits() {
                let setting = match &*met.setting {
                    "" => String::new(),
                    words => format!(", {words}"),
                };
                let (a_m, b_m, ticks) = (a.distance_m, b.distance_m, a.ticks);
                return Err(VersusError::Ways { seed, setting, a_m, b_m, ticks });
            } else {
                met.pairs.push((seed, [a, b]));
            }
        }
        Ok(met)
    }

    fn contest(&self, metrics: &[Metric], asked: bool, level: f64, names: [&str; 2]) -> Contest {
        let has = |metric: &Metric| {
            asked
                || self
                    .pairs
                    .iter()
                    .any(|(_, runs)| runs.iter().any(|r| figure(r, *metric).is_some()))
        };
        let mut seen = BTreeSet::new();
        let wanted = metrics.iter().filter(|m| has(m) && seen.insert(**m));
        Contest {
            setting: self.setting.clone(),
            seeds: self.pairs.len(),
            alone: self.alone.clone(),
            cut_short: self.cut_short.clone(),
            outcomes: wanted.map(|m| self.outcome(*m, level, names)).collect(),
        }
    }

    fn outcome(&self, metric: Metric, level: f64, names: [&str; 2]) -> Outcome {
        let of = |(seed, runs): &(u64, [&Run; 2])| (*seed, runs.map(|run| figure(run, metric)));
        let figures = self.pairs.iter().map(of).collect();
        Outcome::of(metric, figures, metric.may_never_end(), (names, "seeds"), level)
    }
}

impl Outcome {
    /// Compares figures of A and B by seed. With `missing_is_worse`, a run without a figure
    /// is worse than any with it.
    #[must_use]
    pub fn of(
        metric: Metric,
        figures: BTreeMap<u64, [Option<f64>; 2]>,
        missing_is_worse: bool,
        (names, samples): ([&str; 2], &'static str),
        level: f64,
    ) -> Self {
        let mut paired = Paired::of(&figures, level);
        let one_sided = match missing_is_worse {
            true => one_sided(&figures),
            false => [0, 0],
        };
        let signs = &mut paired.signs;
        signs.above += one_sided[0];
        signs.below += one_sided[1];
        // A has less where B − A is above zero.
        let (wins, ties, sign_p) = ([signs.above, signs.below], signs.ties, signs.p_value());
        let interval = paired.interval();
        let better = match interval {
            // The mean is over those alone that came to it.
            _ if one_sided != [0, 0] => {
                let likely = if wins[0] > wins[1] { Better::A } else { Better::B };
                (sign_p < 1.0 - level).then_some(likely)
            }
            [_, high] if high < 0.0 => Some(Better::B),
            [low, _] if low > 0.0 => Some(Better::A),
            _ => None,
        };
        let mut outcome = Self {
            metric,
            unit: metric.unit(),
            samples,
            figures,
            interval,
            effect_percent: 100.0 * paired.difference / paired.means[0],
            wins,
            ties,
            one_sided,
            sign_p,
            better,
            verdict: String::new(),
            paired,
        };
        outcome.verdict = outcome.sentence(names, level);
        outcome
    }
}

/// Seeds in which A alone has a figure, and in which B alone has one.
fn one_sided(figures: &BTreeMap<u64, [Option<f64>; 2]>) -> [u64; 2] {
    let alone = |side: usize| {
        let alone = figures.values().filter(|f| f[side].is_some() && f[1 - side].is_none());
        alone.count() as u64
    };
    [alone(0), alone(1)]
}

fn figure(run: &Run, metric: Metric) -> Option<f64> {
    let at = Metric::ALL.iter().position(|m| *m == metric)?;
    run.figures.get(at).copied().filter(|value| value.is_finite())
}
