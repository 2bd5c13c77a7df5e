//! Values as bits, for comparing and for showing.

use rusty_contract::Reply;

/// The numbers of a reply, in order, with their names.
#[must_use]
pub fn reply_values(reply: &Reply) -> Vec<(String, f64)> {
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
#[must_use]
pub fn show(value: f64) -> String {
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
