//! What a comparison says, in words.

use std::fmt;

use rusty_contract::TextTable;

use super::contest::{Better, Contest, Outcome, Versus};
use crate::sweep::paired::listed;

impl Outcome {
    /// All of it in a sentence, for `names` A and B.
    #[must_use]
    pub fn sentence(&self, names: [&str; 2], level: f64) -> String {
        let (what, unit) = (self.metric.words(), self.metric.shown_unit());
        let samples = self.samples;
        let number = |value: f64| self.metric.shown(value);
        if self.one_sided != [0, 0] {
            return self.one_sided_sentence(names, level);
        }
        let broken = self.interval.iter().any(|bound| !bound.is_finite());
        if self.paired.pairs < 2 || broken {
            let pairs = self.paired.pairs;
            return format!("{what}: nothing can be said of {pairs} pairs with a figure of both");
        }
        if self.wins == [0, 0] {
            return format!("{what}: equal to the bit in all {} {samples}", self.paired.pairs);
        }
        let decided = self.decided();
        let [low, high] = self.interval.map(number);
        let interval = format!("{} % in [{low}, {high}]{unit}", per_cent_of(level));
        let wins = |side: Better| self.won(names, side);
        let many = if self.wins[1] >= self.wins[0] { Better::B } else { Better::A };
        let unlikely = self.sign_p < 1.0 - level;
        let Some(better) = self.better else {
            let with_the_mean = (self.paired.difference < 0.0) == (many == Better::B);
            let but = match (unlikely, with_the_mean) {
                (false, _) => String::new(),
                (true, true) => {
                    format!("; better in most {samples}, but by amounts too unlike for the mean")
                }
                (true, false) => format!(
                    "; better in most {samples}, but not on average: a few {samples} weigh against it"
                ),
            };
            return format!(
                "{what}: no difference shown: {} with {}{unit}, {interval}; {}{but}",
                names[1],
                signed(self.paired.difference, &number),
                wins(many)
            );
        };
        let (winner, loser, word) = match better {
            Better::A => (names[0], names[1], "more"),
            Better::B => (names[1], names[0], "less"),
        };
        let subject =
            if better == Better::A { format!("{loser} has") } else { "it has".to_owned() };
        // As few as these are as likely all of one sign.
        let too_few = 2.0 * 0.5f64.powi(decided.min(1000) as i32) >= 1.0 - level;
        let but = match (unlikely && many == better, many == better) {
            (true, _) => String::new(),
            (_, true) if too_few => format!("; too few {samples} for the signs to tell"),
            (_, true) => "; the signs alone do not show it".to_owned(),
            (_, false) => {
                format!("; the mean owes it to a few {samples}, the signs do not show it")
            }
        };
        format!(
            "{what}: {winner} is better: {subject} {}{unit} {word} ({}), {interval}; {}{but}",
            number(self.paired.difference.abs()),
            percent(self.effect_percent),
            wins(better)
        )
    }
}

impl Outcome {
    /// Seeds in which one of them has less.
    fn decided(&self) -> u64 {
        self.wins[0] + self.wins[1]
    }

    fn won(&self, names: [&str; 2], side: Better) -> String {
        let (name, wins) = match side {
            Better::A => (names[0], self.wins[0]),
            Better::B => (names[1], self.wins[1]),
        };
        let ties = if self.ties > 0 { format!(" ({} ties)", self.ties) } else { String::new() };
        let (decided, p) = (self.decided(), probability(self.sign_p));
        format!("{name} wins {wins} of {decided} {}{ties}, p = {p}", self.samples)
    }

    /// Where it did not happen in all runs, the signs decide: a mean would be over
    /// those alone in which it did.
    fn one_sided_sentence(&self, names: [&str; 2], level: f64) -> String {
        let ([only_a, only_b], [a, b], pairs) = (self.one_sided, names, self.paired.pairs);
        let many = if self.wins[1] > self.wins[0] { Better::B } else { Better::A };
        let verdict = match self.better {
            Some(Better::A) => format!("{a} is better"),
            Some(Better::B) => format!("{b} is better"),
            None => format!("no difference shown at {} %", per_cent_of(level)),
        };
        let means = if pairs > 0 { ", over which the means are" } else { "" };
        format!(
            "{}: {verdict}: {}; {a} alone came to it in {only_a} {}, {b} alone in {only_b}, both \
             in {pairs}{means}",
            self.metric.words(),
            self.won(names, many),
            self.samples
        )
    }
}

/// A level in per cent, with as many digits as tell it from 100.
fn per_cent_of(level: f64) -> String {
    let text = format!("{:.10}", 100.0 * level);
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn signed(value: f64, number: &dyn Fn(f64) -> String) -> String {
    let sign = if value < 0.0 { "−" } else { "+" };
    format!("{sign}{}", number(value.abs()))
}

fn percent(value: f64) -> String {
    if value.abs() < 100.0 { format!("{value:+.1} %") } else { format!("{value:+.0} %") }
}

/// A probability in few digits.
fn probability(p: f64) -> String {
    if p >= 0.001 { format!("{p:.3}") } else { format!("{p:.0e}") }
}

impl fmt::Display for Versus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (a, b) = (&self.a, &self.b);
        write!(f, "A  {} ({})\nB  {} ({})", a.name, a.table, b.name, b.table)?;
        for contest in &self.settings {
            let setting = if contest.setting.is_empty() { "" } else { " · " };
            write!(f, "\n\n{} seeds of both{setting}{}", contest.seeds, contest.setting)?;
            write!(f, "\n{}", contest.table())?;
            for outcome in &contest.outcomes {
                write!(f, "\n{}", outcome.verdict)?;
            }
            contest.lacks(f, [&a.name, &b.name])?;
        }
        if !self.remarks.is_empty() {
            writeln!(f)?;
        }
        self.remarks.iter().try_for_each(|remark| write!(f, "\n{remark}"))
    }
}

impl Contest {
    fn table(&self) -> TextTable {
        let mut table =
            TextTable::new("metric  >mean A  >mean B  >B − A  >wins A:B  >pairs  >runs saved");
        for o in &self.outcomes {
            let number = |value: f64| match value.is_finite() {
                true => format!("{}{}", o.metric.shown(value), o.metric.shown_unit()),
                false => "–".to_owned(),
            };
            let [a, b] = o.paired.means.map(number);
            let saved = match o.paired.variance_reduction {
                factor if factor > 1000.0 && factor.is_finite() => ">1000×".to_owned(),
                factor if factor.is_finite() => format!("{factor:.1}×"),
                _ => "–".to_owned(),
            };
            let wins = format!("{}:{}", o.wins[0], o.wins[1]);
            let difference = number(o.paired.difference);
            table.row(&[&o.metric.words(), &a, &b, &difference, &wins, &o.paired.pairs, &saved]);
        }
        table
    }

    /// What is not in the pairs.
    fn lacks(&self, f: &mut fmt::Formatter<'_>, names: [&str; 2]) -> fmt::Result {
        for (seeds, other) in self.alone.iter().zip(["B", "A"]) {
            if !seeds.is_empty() {
                write!(f, "\n{other} lacks {}", listed(seeds))?;
            }
        }
        if !self.cut_short.is_empty() {
            write!(f, "\nleft out, one of the two ended earlier: {}", listed(&self.cut_short))?;
        }
        for outcome in &self.outcomes {
            for (seeds, name) in outcome.paired.missing.iter().zip(names) {
                if !seeds.is_empty() {
                    let (what, count) = (outcome.metric.words(), seeds.len());
                    write!(f, "\n{name} has no {what} in {count} runs: {}", listed(seeds))?;
                }
            }
        }
        Ok(())
    }
}
