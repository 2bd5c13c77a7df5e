//! Two ticks, field by field, bit by bit.

use rusty_contract::Reply;
use rusty_contract::log::TickRecord;
use serde::Serialize;

use crate::bits;

/// The first thing that differs between two ticks.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Mismatch {
    /// The tick.
    pub tick: u64,
    /// Whose answer it is in; null where it is in the frame or the truth.
    pub participant: Option<String>,
    /// The field: `left_ticks`, `truth.x_m`, `ranges_m[17]`, `estimate y_m`, …
    pub field: String,
    /// One value, with its bits.
    pub a: String,
    /// The other value, with its bits.
    pub b: String,
}

impl std::fmt::Display for Mismatch {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "tick {}, {}: {} and {}", self.tick, self.place(), self.a, self.b)
    }
}

impl Mismatch {
    /// Participant and field.
    #[must_use]
    pub fn place(&self) -> String {
        match &self.participant {
            Some(name) => format!("{name}, {}", self.field),
            None => self.field.clone(),
        }
    }
}

/// Compares two frames (and truths) of the same tick.
#[must_use]
pub fn frames(a: &TickRecord, b: &TickRecord, dt_s: f64) -> Option<Mismatch> {
    let at = |field: &str, x: String, y: String| {
        let field = field.to_owned();
        Some(Mismatch { tick: a.tick, participant: None, field, a: x, b: y })
    };
    if a.tick != b.tick {
        return at("tick", a.tick.to_string(), b.tick.to_string());
    }
    for (field, x, y) in
        [("left_ticks", a.ticks.left, b.ticks.left), ("right_ticks", a.ticks.right, b.ticks.right)]
    {
        if x != y {
            return at(field, format!("{x} (bits {x:016x})"), format!("{y} (bits {y:016x})"));
        }
    }
    for (field, x, y) in [
        ("time_s", a.time_s(dt_s), b.time_s(dt_s)),
        ("command.v_m_s", a.command.v_m_s, b.command.v_m_s),
        ("command.omega_rad_s", a.command.omega_rad_s, b.command.omega_rad_s),
    ] {
        if x.to_bits() != y.to_bits() {
            return at(field, bits::show(x), bits::show(y));
        }
    }
    let names = ["truth.x_m", "truth.y_m", "truth.theta_rad"];
    if let Some((field, x, y)) =
        lists(a.truth.as_ref(), b.truth.as_ref(), "truth", |i| names[i].to_owned())
    {
        return at(&field, x, y);
    }
    let (x, y) = (a.ranges_m.as_ref(), b.ranges_m.as_ref());
    let found = lists(x, y, "ranges_m", |i| format!("ranges_m[{i}] (beam {i})"));
    found.and_then(|(field, x, y)| at(&field, x, y))
}

/// Compares two optional lists of numbers; says field and both values.
fn lists(
    a: Option<impl AsRef<[f64]>>,
    b: Option<impl AsRef<[f64]>>,
    whole: &str,
    name: impl Fn(usize) -> String,
) -> Option<(String, String, String)> {
    let length = |l: Option<usize>| l.map_or("absent".to_owned(), |n| format!("{n} values"));
    let (na, nb) = (a.as_ref().map(|l| l.as_ref().len()), b.as_ref().map(|l| l.as_ref().len()));
    if na != nb {
        return Some((whole.to_owned(), length(na), length(nb)));
    }
    let (a, b) = (a?, b?);
    let i = a.as_ref().iter().zip(b.as_ref()).position(|(x, y)| x.to_bits() != y.to_bits())?;
    Some((name(i), bits::show(a.as_ref()[i]), bits::show(b.as_ref()[i])))
}

/// The first thing that differs between two replies.
#[derive(Clone, Debug, PartialEq)]
pub struct ReplyMismatch {
    /// `estimate x_m`, `covariance[1][1]`, `command v_m_s`, or `kind`.
    pub field: String,
    /// One value, with its bits.
    pub a: String,
    /// The other value, with its bits.
    pub b: String,
}

/// Compares two replies bit by bit.
#[must_use]
pub fn reply(a: &Reply, b: &Reply) -> Option<ReplyMismatch> {
    if a.same_bits(b) {
        return None;
    }
    let (va, vb) = (bits::reply_values(a), bits::reply_values(b));
    let same_kind = bits::kind(a) == bits::kind(b) && va.len() == vb.len();
    let field = va.iter().zip(&vb).find(|(x, y)| x.1.to_bits() != y.1.to_bits());
    Some(match field {
        Some((x, y)) if same_kind => {
            let owner = match x.0.as_str() {
                "v_m_s" | "omega_rad_s" => "command ",
                name if name.starts_with("covariance") || name.starts_with("innovation") => "",
                _ => "estimate ",
            };
            let field = format!("{owner}{}", x.0);
            ReplyMismatch { field, a: bits::show(x.1), b: bits::show(y.1) }
        }
        _ => {
            let (a, b) = (bits::reply_text(a), bits::reply_text(b));
            ReplyMismatch { field: "kind".to_owned(), a, b }
        }
    })
}

/// Compares the replies to the same tick; `names` are the answering
/// participants'.
#[must_use]
pub fn replies(tick: u64, names: &[String], a: &[Reply], b: &[Reply]) -> Option<Mismatch> {
    if a.len() != b.len() {
        let (x, y) = (a.len().to_string(), b.len().to_string());
        let field = "number of replies".to_owned();
        return Some(Mismatch { tick, participant: None, field, a: x, b: y });
    }
    a.iter().zip(b).enumerate().find_map(|(i, (x, y))| {
        let ReplyMismatch { field, a, b } = reply(x, y)?;
        let name = names.get(i).map_or_else(|| format!("reply {i}"), Clone::clone);
        Some(Mismatch { tick, participant: Some(name), field, a, b })
    })
}

/// The fields in which two documents differ: path and both values.
#[must_use]
pub fn documents(a: &serde_json::Value, b: &serde_json::Value) -> Vec<String> {
    let mut found = Vec::new();
    walk("", a, b, &mut found);
    found
}

fn walk(path: &str, a: &serde_json::Value, b: &serde_json::Value, found: &mut Vec<String>) {
    use serde_json::Value::{Array, Object};
    let inside = |key: &str| if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
    match (a, b) {
        _ if a == b => {}
        (Object(x), Object(y)) => {
            for key in x.keys().chain(y.keys().filter(|k| !x.contains_key(*k))) {
                let missing = serde_json::Value::Null;
                let (x, y) = (x.get(key).unwrap_or(&missing), y.get(key).unwrap_or(&missing));
                walk(&inside(key), x, y, found);
            }
        }
        (Array(x), Array(y)) if x.len() == y.len() => {
            for (i, (x, y)) in x.iter().zip(y).enumerate() {
                walk(&format!("{path}[{i}]"), x, y, found);
            }
        }
        _ => found.push(format!("{path}: {} and {}", brief(a), brief(b))),
    }
}

/// The longest value that is shown whole, characters of JSON.
const SHOWN_WHOLE: usize = 80;

/// A value on one line: a long list or object (the walls of a world, say) by what
/// it has.
fn brief(value: &serde_json::Value) -> String {
    use serde_json::Value::{Array, Object};
    let whole = value.to_string();
    match value {
        _ if whole.chars().count() <= SHOWN_WHOLE => whole,
        Array(items) => format!("a list of {}", items.len()),
        Object(fields) => {
            let names: Vec<&str> = fields.keys().map(String::as_str).collect();
            format!("an object with {}", names.join(", "))
        }
        _ => whole.chars().take(SHOWN_WHOLE).chain(['…']).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rusty_geometry::{EncoderTicks, SE2, Twist};

    fn record() -> TickRecord {
        TickRecord {
            tick: 3,
            stamp_s: None,
            ticks: EncoderTicks { left: 5, right: -5 },
            command: Twist { v_m_s: 0.5, omega_rad_s: 0.0 },
            truth: Some([1.0, 2.0, 3.0]),
            ranges_m: Some(vec![1.0, 2.5]),
            replies: vec![SE2::new(1.0, 2.0, 3.0).into()],
        }
    }

    #[test]
    fn one_bit_of_a_range_is_named_with_beam_values_and_bits() {
        let (a, mut b) = (record(), record());
        assert_eq!(frames(&a, &b, 0.02), None);
        b.ranges_m = Some(vec![1.0, f64::from_bits(2.5f64.to_bits() ^ 1)]);
        let text = frames(&a, &b, 0.02).unwrap().to_string();
        assert!(
            text.contains("tick 3, ranges_m[1] (beam 1): 2.5 (bits 4004000000000000)"),
            "{text}"
        );
        assert!(text.contains("(bits 4004000000000001)"), "{text}");
    }

    #[test]
    fn every_field_is_seen() {
        let changes: [fn(&mut TickRecord); 8] = [
            |r| r.tick = 4,
            |r| r.stamp_s = Some(0.1),
            |r| r.ticks.left = 6,
            |r| r.ticks.right = 6,
            |r| r.command.omega_rad_s = -0.0,
            |r| r.truth = None,
            |r| r.truth = Some([1.0, 2.0, 3.5]),
            |r| r.ranges_m = None,
        ];
        for (i, change) in changes.iter().enumerate() {
            let mut b = record();
            change(&mut b);
            assert!(frames(&record(), &b, 0.02).is_some(), "change {i}");
        }
    }

    #[test]
    fn long_values_of_documents_are_summarised() {
        let walls = |n: usize| vec![serde_json::json!({ "from": [0.25, 1.5], "to": [2, 3] }); n];
        let a = serde_json::json!({ "seed": 1, "world": { "walls": walls(24) } });
        let b = serde_json::json!({ "seed": 2, "world": { "walls": walls(26) } });
        let found = ["seed: 1 and 2", "world.walls: a list of 24 and a list of 26"];
        assert_eq!(documents(&a, &b), found);
        let fork = serde_json::json!({ "source": { "forked": { "at": 7, "world": walls(9) } } });
        let whole = serde_json::json!({ "source": "simulated" });
        let found = ["source: \"simulated\" and an object with forked"];
        assert_eq!(documents(&whole, &fork), found);
    }

    #[test]
    fn a_reply_is_named_by_participant_and_field() {
        let names = ["dr".to_owned()];
        let a = record().replies;
        let b: Vec<Reply> = vec![SE2::new(1.0, 2.5, 3.0).into()];
        let text = replies(3, &names, &a, &b).unwrap().to_string();
        assert!(text.contains("tick 3, dr, estimate y_m: 2.0 (bits"), "{text}");
        let text = replies(3, &names, &a, &[Reply::Abstain]).unwrap().to_string();
        assert_eq!(text, "tick 3, dr, kind: estimate x_m 1, y_m 2, theta_rad 3 and abstain");
        assert!(replies(3, &names, &a, &[]).is_some());
        assert_eq!(replies(3, &names, &a, &a), None);
    }
}
