//! The absolute error after the estimate was moved as a whole to where it fits the truth
//! best.
//!
//! Source: S. Umeyama, *Least-squares estimation of transformation parameters between
//! two point patterns*, IEEE PAMI 13(4) (1991), without scale; `evo_ape --align`.
//! Departure: in the plane, where the best rotation has a closed form; docs/metrics.md
//! has the cases in which evo differs.

use rusty_geometry::{SE2, trig};

use super::errors::Errors;
use super::scored::Scored;

/// The errors of these ticks after alignment; `None` without a tick.
#[must_use]
pub fn aligned_errors(ticks: &[Scored]) -> Option<Errors> {
    let motion = best_motion(|| ticks.iter().map(|s| (s.estimate, s.truth)))?;
    let mut errors = Errors::expecting(ticks.len() as u64);
    for s in ticks {
        errors.push(&(motion * s.estimate), &s.truth);
    }
    Some(errors)
}

/// The motion that, applied from the left, brings the positions of the first
/// poses as near to those of the second as they will come (least squares).
fn best_motion<I: Iterator<Item = (SE2, SE2)>>(pairs: impl Fn() -> I) -> Option<SE2> {
    let count = pairs().count();
    let mean = |of: fn(&(SE2, SE2)) -> nalgebra::Vector2<f64>| {
        pairs().map(|pair| of(&pair)).sum::<nalgebra::Vector2<f64>>() / count as f64
    };
    let (from_m, to_m) = (mean(|p| p.0.translation()), mean(|p| p.1.translation()));
    let (mut along, mut across) = (0.0, 0.0);
    for (from, to) in pairs() {
        let (from, to) = (from.translation() - from_m, to.translation() - to_m);
        along += from.x * to.x + from.y * to.y;
        across += from.x * to.y - from.y * to.x;
    }
    let rotation = SE2::new(0.0, 0.0, trig::atan2(across, along));
    let turned = rotation.transform_point(&from_m.into());
    let motion = SE2::new(to_m.x - turned.x, to_m.y - turned.y, rotation.theta());
    (count > 0 && motion.is_finite()).then_some(motion)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::position_error_m;

    fn pairs(poses: &[[f64; 3]], moved: SE2) -> Vec<(SE2, SE2)> {
        poses.iter().map(|p| SE2::new(p[0], p[1], p[2])).map(|p| (p, moved * p)).collect()
    }

    #[test]
    fn a_trajectory_that_was_only_moved_is_found_again() {
        let moved = SE2::new(3.0, -2.0, 2.9);
        for poses in [
            &[[0.0, 0.0, 0.0], [1.0, 0.2, 0.3], [2.0, 1.0, 3.0]][..],
            &[[1.0, 1.0, 0.0], [2.0, 2.0, 0.0], [5.0, 5.0, 0.0]], // on a line
        ] {
            let pairs = pairs(poses, moved);
            let found = best_motion(|| pairs.iter().copied()).unwrap();
            assert!(found.boxminus(&moved).norm() < 1e-12, "{found:?}");
        }
    }

    #[test]
    fn who_stands_is_moved_and_not_turned() {
        let pairs = pairs(&[[1.0, 2.0, 0.5]; 3], SE2::new(1.0, 0.0, 0.0));
        let found = best_motion(|| pairs.iter().copied()).unwrap();
        assert_eq!(found, SE2::new(1.0, 0.0, 0.0));
        assert_eq!(best_motion(std::iter::empty), None);
    }

    #[test]
    fn a_mirror_image_is_not_turned_over() {
        // Space would find a rotation about the x axis, and no error at all.
        let points = [[0.0, 0.0], [4.0, 1.0], [8.0, -1.0], [12.0, 0.0]];
        let pose = |y: f64| move |p: &[f64; 2]| SE2::new(p[0], y * p[1], 0.0);
        let pairs: Vec<_> = points.iter().map(|p| (pose(1.0)(p), pose(-1.0)(p))).collect();
        let found = best_motion(|| pairs.iter().copied()).unwrap();
        let error_m = |(e, t): &(SE2, SE2)| position_error_m(&(found * *e), t);
        let worst = pairs.iter().map(error_m).fold(0.0, f64::max);
        assert!(worst > 1.0, "{worst}");
    }
}
