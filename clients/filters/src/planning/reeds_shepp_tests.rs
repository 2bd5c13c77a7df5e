//! Words compared with others that lead to the same pose.

use super::*;
use crate::Random;
use nalgebra::Vector3;
use std::f64::consts::TAU;

fn between(random: &mut Random, from: f64, to: f64) -> f64 {
    from + (to - from) * random.uniform()
}

/// A pose at most `size_m` from the origin in x and y; one in eight with a round
/// heading and one in eight with round coordinates.
fn pose(random: &mut Random, size_m: f64) -> SE2 {
    let mut draw = || between(random, -1.0, 1.0);
    let (mut x, mut y, mut theta) = (size_m * draw(), size_m * draw(), PI * draw());
    if draw() > 0.75 {
        theta = FRAC_PI_2 * (2.0 * draw()).round();
    }
    if draw() > 0.75 {
        (x, y) = (x.round(), y.round());
    }
    SE2::new(x, y, theta)
}

fn error(curve: &Curve, to: &SE2) -> f64 {
    let end = curve.end();
    let turn_rad = wrap_angle(end.theta() - to.theta());
    (end.translation() - to.translation()).norm().max(turn_rad.abs())
}

fn driven(letters: &[Letter]) -> SE2 {
    letters.iter().fold(SE2::identity(), |pose, (turn, length)| {
        pose.boxplus(&Vector3::new(*length, 0.0, turn * length))
    })
}

fn unit_m(to: &SE2) -> f64 {
    reeds_shepp_m(&SE2::identity(), to, 1.0)
}

#[test]
fn every_word_ends_at_the_goal_and_the_shortest_is_the_shortest() {
    let mut random = Random::new(1, 7);
    for k in 0..20_000 {
        let size_m = [0.01, 0.5, 3.0, 20.0][k % 4];
        let (from, to) = (pose(&mut random, size_m), pose(&mut random, size_m));
        let radius_m = between(&mut random, 0.2, 2.0);
        let curve = reeds_shepp(&from, &to, radius_m);
        assert!(error(&curve, &to) < 1e-9, "{curve:?} to {to:?}");
        assert!(curve.pieces.iter().all(|p| p.curvature_per_m.abs() <= 1.0 / radius_m));
        let length_m = curve.length_m();
        assert!((length_m - reeds_shepp_m(&from, &to, radius_m)).abs() < 1e-9);
        assert!(length_m >= (from.translation() - to.translation()).norm() - 1e-9);
        for word in words(&from, &to, radius_m) {
            assert!(error(&Curve::new(from, word), &to) < 1e-9, "{word:?} to {to:?}");
        }
    }
}

#[test]
fn lengths_are_the_same_backwards_in_a_mirror_and_in_reverse() {
    let mut random = Random::new(2, 7);
    for _ in 0..5_000 {
        let to = pose(&mut random, 4.0);
        let length_m = unit_m(&to);
        let others = [
            to.inverse(),
            SE2::new(to.x(), -to.y(), -to.theta()),
            SE2::new(-to.x(), to.y(), -to.theta()),
            SE2::new(-to.x(), -to.y(), to.theta()),
        ];
        for other in others {
            assert!((unit_m(&other) - length_m).abs() < 1e-9, "{to:?} {other:?}");
        }
    }
}

/// Length of the shortest curve without reverse of three pieces (L. E. Dubins, *On
/// curves of minimal length with a constraint on average curvature*, American
/// Journal of Mathematics 79, 1957), by the centres of the circles as complex
/// numbers would have it; from the origin, for radius 1.
fn dubins_m(to: &SE2) -> f64 {
    let forwards = |turn: f64| turn.rem_euclid(TAU);
    let mut best_m = f64::INFINITY;
    for (a, b) in [(L, L), (L, R), (R, L), (R, R)] {
        let normal = Vector2::new(-trig::sin(to.theta()), trig::cos(to.theta()));
        let d = to.translation() + normal * b - Vector2::new(0.0, a);
        let (rho, angle) = (d.norm(), trig::atan2(d.y, d.x));
        let mut consider = |first: f64, middle: f64, second: f64| {
            // Headings where the middle begins and ends.
            let ends = forwards(a * first) + forwards(b * (to.theta() - second));
            best_m = best_m.min(ends + middle);
        };
        if a == b {
            consider(angle, rho, angle);
            if rho <= 4.0 {
                let half = trig::asin(0.25 * rho);
                for half in [half, PI - half] {
                    let (first, second) = (angle + a * half, angle - a * half);
                    consider(first, forwards(2.0 * half), second);
                }
            }
        } else if rho >= 2.0 {
            let heading = angle + a * trig::asin(2.0 / rho);
            consider(heading, (rho * rho - 4.0).sqrt(), heading);
        }
    }
    best_m
}

#[test]
fn no_curve_without_reverse_is_shorter() {
    let mut random = Random::new(3, 7);
    let (mut same, mut shorter) = (0, 0);
    for _ in 0..10_000 {
        let to = pose(&mut random, 6.0);
        let (shortest_m, forwards_m) = (unit_m(&to), dubins_m(&to));
        assert!(shortest_m <= forwards_m + 1e-9, "{shortest_m} {forwards_m} to {to:?}");
        if shortest_m < forwards_m - 1e-9 { shorter += 1 } else { same += 1 }
    }
    assert!(same > 500 && shorter > 500, "{same} {shorter}");
}

#[test]
fn no_random_curve_of_up_to_five_pieces_is_shorter() {
    let mut random = Random::new(4, 7);
    for k in 0..100_000 {
        let most = [0.1, 0.7, 2.0, 4.0][k % 4];
        let count = 1 + (5.0 * random.uniform()) as usize;
        let letters: Vec<Letter> = (0..count)
            .map(|_| {
                let turn = [L, S, R][(3.0 * random.uniform()) as usize];
                (turn, between(&mut random, -most, most))
            })
            .collect();
        let length: f64 = letters.iter().map(|(_, length)| length.abs()).sum();
        let found = unit_m(&driven(&letters));
        assert!(found <= length + 1e-9, "{found} for {length}: {letters:?}");
    }
}

/// The words of the paper's table in §8 with lengths t, u, v, before time flip,
/// reflection and backwards order.
fn paper(t: f64, u: f64, v: f64) -> [Vec<Letter>; 11] {
    let q = FRAC_PI_2;
    [
        vec![(L, t), (S, u), (L, v)],
        vec![(L, t), (S, u), (R, v)],
        vec![(L, t), (R, -u), (L, v)],
        vec![(L, t), (R, -u), (L, -v)],
        vec![(L, t), (R, u), (L, -v)],
        vec![(L, t), (R, u), (L, -u), (R, -v)],
        vec![(L, t), (R, -u), (L, -u), (R, v)],
        vec![(L, t), (R, -q), (S, -u), (L, -v)],
        vec![(L, t), (R, -q), (S, -u), (R, -v)],
        vec![(R, v), (S, u), (R, q), (L, -t)],
        vec![(L, t), (R, -q), (S, -u), (L, -q), (R, v)],
    ]
}

#[test]
fn every_word_of_the_paper_is_found_and_each_is_the_shortest_somewhere() {
    let mut random = Random::new(5, 7);
    let mut shortest = [0; 11];
    for _ in 0..4_000 {
        let [t, u, v] = [(); 3].map(|()| between(&mut random, 0.0, FRAC_PI_2));
        for (k, mut letters) in paper(t, u, v).into_iter().enumerate() {
            if random.uniform() < 0.5 {
                letters.reverse();
            }
            let [mirror, flip] = [(); 2].map(|()| if random.uniform() < 0.5 { 1.0 } else { -1.0 });
            let letters: Vec<Letter> =
                letters.iter().map(|(turn, length)| (mirror * turn, flip * length)).collect();
            let length: f64 = letters.iter().map(|(_, length)| length.abs()).sum();
            let found = unit_m(&driven(&letters));
            assert!(found <= length + 1e-9, "{found} for {length}: {letters:?}");
            shortest[k] += usize::from(found > length - 1e-9);
        }
    }
    assert!(shortest.iter().all(|count| *count > 20), "{shortest:?}");
}

#[test]
fn known_curves() {
    let from = SE2::new(1.0, 1.0, FRAC_PI_2);
    let to = |x: f64, y: f64, theta: f64| from.compose(&SE2::new(x, y, theta));
    // Straight back is one piece, and a place itself none.
    let back = reeds_shepp(&from, &to(-2.0, 0.0, 0.0), 0.5);
    assert_eq!(back.pieces.len(), 1, "{back:?}");
    assert_eq!((back.pieces[0].curvature_per_m, back.pieces[0].length_m), (0.0, -2.0));
    assert!(reeds_shepp(&from, &from, 0.5).pieces.is_empty());
    // A half turn on the spot: three arcs of 60° with two changes of direction.
    let turn = reeds_shepp(&from, &to(0.0, 0.0, PI), 0.5);
    assert!((turn.length_m() - 0.5 * PI).abs() < 1e-9, "{turn:?}");
    assert_eq!((turn.pieces.len(), turn.switches()), (3, 2));
    // Parallel parking, 0.2 m to the left.
    let parking = reeds_shepp(&from, &to(0.0, 0.2, 0.0), 0.5);
    assert!(parking.length_m() < 1.35 && parking.switches() >= 1, "{parking:?}");
    // Lane change while driving: two arcs that touch, and no reverse.
    let angle = trig::acos(1.0 - 0.2);
    let lane = reeds_shepp(&from, &to(trig::sin(angle), 0.2, 0.0), 0.5);
    assert!((lane.length_m() - angle).abs() < 1e-9 && lane.switches() == 0, "{lane:?}");
}
