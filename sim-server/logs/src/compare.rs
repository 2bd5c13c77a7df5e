//! Two ticks, field by field, bit by bit.

use rusty_contract::log::TickRecord;
use rusty_contract::{Frame, Reply};
use rusty_geometry::SE2;
use serde::Serialize;

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

/// What a log would have of this frame, but for the replies.
#[must_use]
pub fn record_of(frame: &Frame, truth: SE2) -> TickRecord {
    TickRecord {
        tick: frame.tick(),
        stamp_s: Some(frame.time_s()),
        ticks: frame.encoders(),
        command: frame.command(),
        truth: Some([truth.x(), truth.y(), truth.theta()]),
        ranges_m: frame.ranges_m().map(<[f64]>::to_vec),
        replies: Vec::new(),
        readings: frame.readings().into(),
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
            return at(field, show(x), show(y));
        }
    }
    let names = ["truth.x_m", "truth.y_m", "truth.theta_rad"];
    if let Some((field, x, y)) =
        lists(a.truth.as_ref(), b.truth.as_ref(), "truth", |i| names[i].to_owned())
    {
        return at(&field, x, y);
    }
    let (x, y) = (a.readings.get(), b.readings.get());
    if x.present() != y.present() {
        return at("readings", format!("{:?}", x.present()), format!("{:?}", y.present()));
    }
    for ((field, x), (_, y)) in x.named().zip(y.named()) {
        if x.to_bits() != y.to_bits() {
            return at(&field, show(x), show(y));
        }
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
    Some((name(i), show(a.as_ref()[i]), show(b.as_ref()[i])))
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
    let (va, vb) = (reply_values(a), reply_values(b));
    let same_kind = kind(a) == kind(b) && va.len() == vb.len();
    let field = va.iter().zip(&vb).find(|(x, y)| x.1.to_bits() != y.1.to_bits());
    Some(match field {
        Some((x, y)) if same_kind => {
            let owner = match x.0.as_str() {
                "v_m_s" | "omega_rad_s" => "command ",
                name if name.starts_with("covariance") || name.starts_with("innovation") => "",
                _ => "estimate ",
            };
            let field = format!("{owner}{}", x.0);
            ReplyMismatch { field, a: show(x.1), b: show(y.1) }
        }
        _ => {
            let (a, b) = (reply_text(a), reply_text(b));
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

/// The numbers of a reply, in order, with their names.
fn reply_values(reply: &Reply) -> Vec<(String, f64)> {
    let mut values = Vec::new();
    if let Some(e) = reply.estimate() {
        let p = e.pose_in_world;
        values.push(("x_m".to_owned(), p.x()));
        values.push(("y_m".to_owned(), p.y()));
        values.push(("theta_rad".to_owned(), p.theta()));
        for (i, value) in e.covariance.iter().flatten().enumerate() {
            values.push((format!("covariance[{}][{}]", i / 3, i % 3), *value));
        }
        if let Some(innovation) = e.innovation {
            values.push(("innovation nis".to_owned(), innovation.nis));
            values.push(("innovation degrees".to_owned(), f64::from(innovation.degrees)));
        }
    }
    if let Some(c) = reply.command() {
        values.push(("v_m_s".to_owned(), c.v_m_s));
        values.push(("omega_rad_s".to_owned(), c.omega_rad_s));
    }
    values
}

/// A number with all its digits and its bits.
fn show(value: f64) -> String {
    format!("{value:?} (bits {:016x})", value.to_bits())
}

/// The word for a kind of reply.
#[must_use]
pub fn kind(reply: &Reply) -> &'static str {
    match reply {
        Reply::Missing => "missing",
        Reply::Abstain => "abstain",
        Reply::Taken => "taken",
        Reply::Estimate(_) => "estimate",
        Reply::Command(_) => "command",
        Reply::Both(..) => "both",
    }
}

/// A reply for people: its kind and every number in it.
#[must_use]
pub fn reply_text(reply: &Reply) -> String {
    let numbers = reply_values(reply);
    let numbers = numbers.iter().map(|(name, value)| format!(" {name} {value}"));
    format!("{}{}", kind(reply), numbers.collect::<Vec<_>>().join(","))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rusty_geometry::{EncoderCounts, Twist};

    fn record() -> TickRecord {
        TickRecord {
            tick: 3,
            stamp_s: None,
            ticks: EncoderCounts { left: 5, right: -5 },
            command: Twist { v_m_s: 0.5, omega_rad_s: 0.0 },
            truth: Some([1.0, 2.0, 3.0]),
            ranges_m: Some(vec![1.0, 2.5]),
            replies: vec![SE2::new(1.0, 2.0, 3.0).into()],
            readings: rusty_contract::OwnedReadings::default(),
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
