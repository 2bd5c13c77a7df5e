//! Which way to turn: a free direction near a wanted one, and a command towards
//! it.
//!
//! Source: J. Borenstein, Y. Koren, *The vector field histogram* (IEEE Transactions
//! on Robotics and Automation 7(3), 1991) and I. Ulrich, J. Borenstein, *VFH+:
//! reliable obstacle avoidance for fast mobile robots* (ICRA 1998): directions are
//! sectors, obstacles are enlarged by the robot's radius, a sector is free or not,
//! and of the free ones that of least cost is taken.
//!
//! Departures, and why: the histogram counts cells of a grid, because sonars are
//! vague; a laser is not, so a sector has the distance that the body can go in it
//! ([`Surroundings::clear_towards_m`]). The cost is how far a sector is from the
//! wanted direction alone: the robot can turn on the spot, and what it did
//! before is in the wanted direction.

use rusty_geometry::{Twist, wrap_angle};

use crate::surroundings::{Caution, Surroundings};

/// Directions that are looked at: one every 5°.
const SECTORS: i32 = 72;

/// More room than the rule of [`Surroundings::limit`] asks for, m: a direction
/// that scrapes along is no direction.
const COMFORT_M: f64 = 0.05;

/// A robot that looks this far away from where it is to go turns on the spot.
const ON_THE_SPOT_RAD: f64 = 1.0;

/// An arc of which less than this share is admissible is given up for a turn on the spot,
const HARDLY: f64 = 0.1;

/// unless the robot looks into the direction already, to this, rad.
const ALIGNED_RAD: f64 = 0.02;

/// Turn rate for each radian that the direction is off, 1/s.
const TURN_PER_S: f64 = 2.5;

/// So far a free direction must be free, m, where the aim is not nearer.
pub(crate) const NEED_M: f64 = 0.35;

/// Centre of sector `k`, rad from ahead.
fn sector_rad(k: i32) -> f64 {
    wrap_angle(f64::from(k) * std::f64::consts::TAU / f64::from(SECTORS))
}

/// The direction, rad from ahead, nearest to `wanted_rad` in which the robot can
/// go `need_m`, and how far it can; where there is none, the one in which it can
/// go farthest.
pub fn free_direction(around: &Surroundings, wanted_rad: f64, need_m: f64) -> (f64, f64) {
    let clear = |rad: f64| (rad, around.clear_towards_m(rad, COMFORT_M));
    // The wanted one itself is no sector's centre.
    let wanted = clear(wanted_rad);
    if wanted.1 >= need_m {
        return wanted;
    }
    let off = |rad: f64| wrap_angle(rad - wanted_rad).abs();
    let sectors = (0..SECTORS).map(|k| clear(sector_rad(k)));
    sectors.fold(wanted, |best, next| {
        let better = match (best.1 >= need_m, next.1 >= need_m) {
            (false, true) => true,
            (true, false) => false,
            (true, true) => off(next.0) < off(best.0),
            (false, false) => next.1 > best.1,
        };
        if better { next } else { best }
    })
}

/// How far the robot can go in each sector: its direction, rad from ahead, and
/// the distance, m.
pub fn sectors(around: &Surroundings) -> impl Iterator<Item = (f64, f64)> + '_ {
    (0..SECTORS).map(|k| (sector_rad(k), around.clear_towards_m(sector_rad(k), COMFORT_M)))
}

/// A command that turns the robot into this direction, rad from ahead, while it
/// drives; on the spot where that is far.
pub fn towards(bearing_rad: f64, caution: &Caution) -> Twist {
    let most = caution.turn_rad_s;
    let omega_rad_s = (TURN_PER_S * bearing_rad).clamp(-most, most);
    let share = (1.0 - bearing_rad.abs() / ON_THE_SPOT_RAD).max(0.0);
    Twist { v_m_s: caution.speed_m_s * share, omega_rad_s }
}

/// The admissible command into this direction, rad from ahead. A direction may be
/// free and the arc into it not, as next to the post of a door: then it turns first.
pub fn steer(around: &Surroundings, bearing_rad: f64, caution: &Caution) -> Twist {
    let wanted = towards(bearing_rad, caution);
    let given = around.limit(wanted);
    if given.v_m_s < HARDLY * wanted.v_m_s && bearing_rad.abs() > ALIGNED_RAD {
        return around.limit(Twist { v_m_s: 0.0, ..wanted });
    }
    given
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surroundings::tests::seen_from;
    use rusty_geometry::SE2;

    #[test]
    fn a_door_beside_the_wall_is_found() {
        // In the corridor, the study's door (x 6 to 7) is ahead to the left.
        let around = seen_from(SE2::new(5.6, 4.5, std::f64::consts::FRAC_PI_2));
        let (ahead, far_m) = free_direction(&around, 0.0, 1.5);
        assert!(ahead < -0.5 && ahead > -1.4 && far_m >= 1.5, "{ahead} {far_m}");
        let free = sectors(&around).filter(|(_, far_m)| *far_m > 1.5).count();
        assert!(free > 4 && free < 40, "{free}");
    }

    #[test]
    fn a_free_way_is_taken_as_it_is_and_of_none_the_widest() {
        let around = seen_from(SE2::new(4.0, 4.5, 0.0));
        assert_eq!(free_direction(&around, 0.01, 1.0).0, 0.01);
        let (_, far_m) = free_direction(&around, 1.5, 100.0);
        assert!(sectors(&around).all(|(_, other_m)| other_m <= far_m), "{far_m}");
    }

    #[test]
    fn beside_a_post_it_turns_before_it_drives() {
        // The study's door ends at x = 7, y = 5: poses around its post.
        let caution = Caution::default();
        let mut turned = 0;
        for k in 0..240 {
            let (x, y) = (6.78 + 0.015 * f64::from(k % 12), 4.98 + 0.01 * f64::from(k / 12 % 5));
            let around = seen_from(SE2::new(x, y, -1.4 + 0.3 * f64::from(k / 60)));
            let (free_rad, clear_m) = free_direction(&around, 0.0, 0.35);
            let twist = steer(&around, free_rad, &caution);
            assert!(clear_m < 0.35 || twist != Twist::default(), "{k}: {free_rad}, {twist:?}");
            let arc = around.limit(towards(free_rad, &caution));
            turned += u32::from(clear_m >= 0.35 && twist.v_m_s == 0.0 && arc == Twist::default());
        }
        assert!(turned > 0, "no arc into a free direction was blocked");
    }

    #[test]
    fn who_looks_away_turns_first() {
        let caution = Caution::default();
        let twist = towards(2.0, &caution);
        assert_eq!((twist.v_m_s, twist.omega_rad_s), (0.0, caution.turn_rad_s));
        let twist = towards(-0.1, &caution);
        assert!(twist.v_m_s > 0.4 && twist.omega_rad_s == -0.25, "{twist:?}");
    }
}
