//! Values as bits, for comparing and for showing.

use rusty_contract::Reply;

/// Whether two replies are equal in every bit (`==` calls 0 and −0 equal, and
/// no NaN equal to itself).
#[must_use]
pub fn same(a: &Reply, b: &Reply) -> bool {
    std::mem::discriminant(a) == std::mem::discriminant(b) && numbers(a) == numbers(b)
}

/// All numbers of a reply as bits, in a row of fixed length, after a word that
/// says which there are.
fn numbers(reply: &Reply) -> [u64; 15] {
    let mut row = [0; 15];
    if let Some(e) = reply.estimate() {
        let p = e.pose_in_world;
        row[0] = 1 + u64::from(e.covariance.is_some());
        for (place, value) in row[1..4].iter_mut().zip([p.x(), p.y(), p.theta()]) {
            *place = value.to_bits();
        }
        for (place, value) in row[4..13].iter_mut().zip(e.covariance.iter().flatten()) {
            *place = value.to_bits();
        }
    }
    if let Some(c) = reply.command() {
        row[13] = c.v_m_s.to_bits();
        row[14] = c.omega_rad_s.to_bits();
    }
    row
}

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

#[cfg(test)]
mod tests {
    use super::*;
    use rusty_geometry::{SE2, Twist};

    #[test]
    fn every_bit_counts() {
        let a: Reply = SE2::new(0.0, 1.0, 2.0).into();
        let b: Reply = SE2::new(-0.0, 1.0, 2.0).into();
        assert!(a == b && !same(&a, &b) && same(&a, &a));
        assert!(!same(&Reply::Abstain, &Reply::Taken));
        let c: Reply = Twist { v_m_s: 0.0, omega_rad_s: 0.0 }.into();
        let d: Reply = Twist { v_m_s: 0.0, omega_rad_s: -0.0 }.into();
        assert!(!same(&c, &d));
    }
}
