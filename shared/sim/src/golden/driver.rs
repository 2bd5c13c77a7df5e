//! The driver of the golden runs: commands from a formula.

use rusty_geometry::{Twist, trig};

/// The command for tick `tick`, body frame: a function of its number alone, in
/// portable arithmetic. Mostly forward, weaving, at times backward; changes in
/// every tick, so that no arc is like the one before.
#[must_use]
pub fn driver_command(tick: u64) -> Twist {
    // Small whole numbers: every conversion is exact.
    let (long, short) = ((tick % 61) as f64, (tick % 7) as f64);
    Twist {
        v_m_s: 0.11 * short - 0.05 + 0.07 * trig::cos(0.3 * long),
        omega_rad_s: 1.7 * trig::sin(0.19 * long) - 0.13,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_weaves_forward_and_backward() {
        let all: Vec<Twist> = (0..427).map(driver_command).collect();
        assert!(all.windows(2).all(|pair| pair[0] != pair[1]));
        assert!(all.iter().any(|c| c.v_m_s < 0.0) && all.iter().any(|c| c.v_m_s > 0.6));
        assert!(
            all.iter().any(|c| c.omega_rad_s < -1.5) && all.iter().any(|c| c.omega_rad_s > 1.5)
        );
    }
}
