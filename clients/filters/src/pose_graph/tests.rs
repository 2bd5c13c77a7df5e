//! The graph against worked cases, finite differences and a dense solution.

use nalgebra::{DMatrix, DVector};

use super::*;
use crate::Random;

fn constraint(
    from: usize,
    to: usize,
    motion: SE2,
    information: Matrix3<f64>,
    kind: Kind,
) -> Constraint {
    Constraint { from, to, motion, information, kind }
}

/// Random motions round a polygon, a loop at its end, and one across it.
fn polygon(corners: usize, seed: u64) -> PoseGraph {
    let mut random = Random::new(seed, 1);
    let mut graph = PoseGraph::new(SE2::new(2.0, -1.0, 0.7));
    let turn_rad = std::f64::consts::TAU / corners as f64;
    let mut information = || {
        let root = Matrix3::from_fn(|_, _| random.normal());
        (root * root.transpose() + Matrix3::identity()) * 100.0
    };
    let side = |error: f64| SE2::new(1.0 + error, -error, turn_rad + error);
    for k in 1..corners {
        graph.extend(&side(0.01 * (k % 3) as f64), &information());
    }
    let last = corners - 1;
    graph.constrain(constraint(last, 0, side(0.0), information(), Kind::Loop));
    let across = graph.poses()[1].inverse() * graph.poses()[last - 1];
    let across = across.boxplus(&Vector3::new(0.02, 0.01, -0.02));
    graph.constrain(constraint(1, last - 1, across, information(), Kind::Loop));
    graph
}

#[test]
fn jacobians_are_those_of_finite_differences() {
    let poses = [SE2::new(0.3, -1.0, 0.4), SE2::new(1.7, 0.2, -2.0)];
    let motion = SE2::new(0.5, 1.0, 2.8);
    let c = constraint(0, 1, motion, Matrix3::identity(), Kind::Chain);
    let linear = c.linear(&poses);
    for axis in 0..3 {
        let mut by = Vector3::zeros();
        by[axis] = 1e-6;
        for (side, jacobian) in [linear.of_from, linear.of_to].iter().enumerate() {
            let moved = |by: &Vector3<f64>| {
                let mut poses = poses;
                poses[side] = poses[side].boxplus(by);
                c.residual(&poses)
            };
            let found = (moved(&by) - moved(&-by)) / 2e-6;
            assert!((found - jacobian.column(axis)).norm() < 1e-8, "{side} {axis}: {found}");
        }
    }
}

#[test]
fn a_loop_on_a_line_is_shared_by_information() {
    // Three poses on a line, 1 m apart by the wheels, variance 1 each (in units of
    // 10⁻⁴ m²); a loop says 2.3 m from the first to the last, variance 1. The
    // textbook's answer: the 0.3 m are shared in three equal parts, one of them
    // remains with the loop; the last pose has the variance 2 · 1 / (2 + 1).
    let unit = Matrix3::identity() * 1e4;
    let mut graph = PoseGraph::new(SE2::identity());
    graph.extend(&SE2::new(1.0, 0.0, 0.0), &unit);
    graph.extend(&SE2::new(1.0, 0.0, 0.0), &unit);
    // A chain's weight is always 1: here nothing is to be scaled.
    graph.constrain(constraint(0, 2, SE2::new(2.3, 0.0, 0.0), unit, Kind::Chain));
    graph.optimise().unwrap();
    assert!((graph.poses()[1].x() - 1.1).abs() < 1e-9, "{:?}", graph.poses());
    assert!((graph.poses()[2].x() - 2.2).abs() < 1e-9, "{:?}", graph.poses());
    let variance = graph.last_covariance().unwrap()[(0, 0)];
    assert!((variance - 1e-4 * 2.0 / 3.0).abs() < 1e-12, "{variance}");
    // With four times the information in the loop, it yields a ninth.
    let mut graph = PoseGraph::new(SE2::identity());
    graph.extend(&SE2::new(1.0, 0.0, 0.0), &unit);
    graph.extend(&SE2::new(1.0, 0.0, 0.0), &unit);
    graph.constrain(constraint(0, 2, SE2::new(2.3, 0.0, 0.0), unit * 4.0, Kind::Chain));
    graph.optimise().unwrap();
    assert!((graph.poses()[2].x() - (2.3 - 0.3 / 9.0)).abs() < 1e-9, "{:?}", graph.poses());
}

#[test]
fn the_optimum_is_that_of_dense_gauss_newton() {
    let mut graph = polygon(8, 3);
    let mut poses = graph.poses().to_vec();
    graph.optimise().unwrap();
    // The same cost, by numerical derivatives and a dense solver.
    let residuals = |poses: &[SE2]| -> DVector<f64> {
        let roots = graph.constraints().iter().map(|c| {
            let root = c.information.cholesky().unwrap().l().transpose();
            root * c.residual(poses) * c.weight(c.chi2(poses), SUSPECT_CHI2).sqrt()
        });
        DVector::from_iterator(3 * graph.constraints().len(), roots.flat_map(|r| [r.x, r.y, r.z]))
    };
    let free = 3 * (poses.len() - 1);
    for _ in 0..10 {
        let at = residuals(&poses);
        let mut jacobian = DMatrix::zeros(at.len(), free);
        for k in 0..free {
            let by = Vector3::from_fn(|axis, _| if axis == k % 3 { 1e-6 } else { 0.0 });
            let moved = |by: &Vector3<f64>| {
                let mut poses = poses.clone();
                poses[1 + k / 3] = poses[1 + k / 3].boxplus(by);
                residuals(&poses)
            };
            jacobian.set_column(k, &((moved(&by) - moved(&-by)) / 2e-6));
        }
        let step = (jacobian.transpose() * &jacobian).lu().solve(&-(jacobian.transpose() * at));
        let step = step.unwrap();
        for (k, pose) in poses[1..].iter_mut().enumerate() {
            *pose = pose.boxplus(&step.fixed_rows::<3>(3 * k).into_owned());
        }
    }
    for (found, expected) in graph.poses().iter().zip(&poses) {
        assert!(found.boxminus(expected).norm() < 1e-6, "{found:?} for {expected:?}");
    }
}

#[test]
fn covariances_between_poses_are_those_of_the_dense_inverse() {
    let mut graph = polygon(7, 5);
    graph.optimise().unwrap();
    let last = graph.poses().len() - 1;
    let (matrix, _) = graph.system(SUSPECT_CHI2);
    let factor = Cholesky::of(&matrix).unwrap();
    let columns: Vec<_> = (0..last).map(|k| factor.inverse_column(k)).collect();
    let from = [0, 2, last - 1];
    let motions = graph.to_last(&from).unwrap();
    for (k, motion) in from.into_iter().zip(&motions) {
        let ad = motion.now_in_then.inverse().adjoint();
        // (−Ad, 1) Σ (−Ad, 1)ᵀ, with zeros for the pose that is certain.
        let block = |i: usize, j: usize| {
            if i == 0 || j == 0 { Matrix3::zeros() } else { columns[j - 1][i - 1] }
        };
        let expected = block(last, last) + ad * block(k, k) * ad.transpose()
            - ad * block(k, last)
            - block(last, k) * ad.transpose();
        // Of the last step but one: what is left is less than it moved.
        assert!((motion.covariance - expected).norm() < 1e-4 * expected.norm(), "{k}");
    }
    let world = graph.last_covariance().unwrap();
    assert!((world - motions[0].covariance).norm() < 1e-12, "{world}");
}

#[test]
fn covariances_are_those_of_noise_that_is_drawn() {
    // A chain and a loop with noise of that covariance, a thousand times.
    let information = Matrix3::from_diagonal(&Vector3::new(1e4, 4e4, 2.5e4));
    let deviations = Vector3::new(0.01, 0.005, 1.0 / 158.113_883);
    let (side, corners) = (SE2::new(1.0, 0.0, 1.2), 6);
    let mut random = Random::new(11, 1);
    let mut noisy =
        |motion: &SE2| motion.boxplus(&deviations.map(|deviation| deviation * random.normal()));
    let truth = (1..corners).fold(SE2::identity(), |pose, _| pose * side);
    let (mut sum, mut said, draws) = (0.0, Matrix3::zeros(), 1000);
    for _ in 0..draws {
        let mut graph = PoseGraph::new(SE2::identity());
        (1..corners).for_each(|_| graph.extend(&noisy(&side), &information));
        let motion = noisy(&truth);
        graph.constrain(constraint(0, corners - 1, motion, information, Kind::Chain));
        graph.optimise().unwrap();
        said = graph.last_covariance().unwrap();
        let error = truth.boxminus(&graph.poses()[corners - 1]);
        sum += (error.transpose() * said.try_inverse().unwrap() * error).x;
    }
    let anees = sum / f64::from(draws);
    assert!((anees - 3.0).abs() < 0.3, "{anees}, {said}");
}

#[test]
fn a_wrong_loop_bends_little() {
    let unit = Matrix3::identity() * 1e4;
    let bent = |kind: Kind| {
        let mut graph = PoseGraph::new(SE2::identity());
        (0..20).for_each(|_| graph.extend(&SE2::new(0.5, 0.0, 0.0), &unit));
        graph.constrain(constraint(2, 18, SE2::new(3.0, 1.0, 0.5), unit, kind));
        graph.optimise().unwrap();
        (graph.poses()[20].translation() - nalgebra::Vector2::new(10.0, 0.0)).norm()
    };
    assert!(bent(Kind::Chain) > 3.0, "{}", bent(Kind::Chain));
    assert!(bent(Kind::Loop) < 0.1, "{}", bent(Kind::Loop));
}

#[test]
fn right_loops_correct_an_uncertain_motion_that_is_far_off() {
    // Out and back along a line; the motion in the middle is off by 1.5 m and 0.4 rad, about
    // as uncertain as that. The loops' χ² is in the ten thousands before they count.
    let (sure, unsure) = (Matrix3::identity() * 1e4, Matrix3::identity() * 0.5);
    let mut graph = PoseGraph::new(SE2::identity());
    for k in 0..20 {
        let out = SE2::new(if k < 10 { 0.5 } else { -0.5 }, 0.0, 0.0);
        let (motion, information) =
            if k == 10 { (out * SE2::new(1.5, 0.3, 0.4), unsure) } else { (out, sure) };
        graph.extend(&motion, &information);
    }
    for k in [16, 18] {
        graph.constrain(constraint(20 - k, k, SE2::identity(), sure, Kind::Loop));
    }
    let worst = graph.constraints().iter().map(|c| c.chi2(graph.poses())).fold(0.0, f64::max);
    assert!(worst > 1e4, "{worst}");
    graph.optimise().unwrap();
    assert!(graph.poses()[20].log().norm() < 0.02, "{:?}", graph.poses()[20]);
}

#[test]
fn the_weight_is_that_of_dynamic_covariance_scaling() {
    // s = 2Φ / (Φ + χ²), and what multiplies Λ is s².
    let chain = constraint(0, 1, SE2::identity(), Matrix3::identity(), Kind::Chain);
    let closing = Constraint { kind: Kind::Loop, ..chain };
    for (of_phi, weight) in [(0.0, 1.0), (1.0, 1.0), (3.0, 0.25), (7.0, 0.0625)] {
        let found = closing.weight(of_phi * SUSPECT_CHI2, SUSPECT_CHI2);
        assert!((found - weight).abs() < 1e-12, "{of_phi}: {found}");
        assert_eq!(chain.weight(of_phi * SUSPECT_CHI2, SUSPECT_CHI2), 1.0);
    }
    // A chain says 0 with the variance 1, a loop 9 with the same: where they come to
    // rest, x = s² (9 − x).
    let mut graph = PoseGraph::new(SE2::identity());
    graph.extend(&SE2::identity(), &Matrix3::identity());
    let motion = SE2::new(9.0, 0.0, 0.0);
    graph.constrain(constraint(0, 1, motion, Matrix3::identity(), Kind::Loop));
    graph.optimise().unwrap();
    let x = graph.poses()[1].x();
    let s = 2.0 * SUSPECT_CHI2 / (SUSPECT_CHI2 + (9.0 - x) * (9.0 - x));
    assert!(s < 0.6 && (x - s * s * (9.0 - x)).abs() < 1e-4, "{x} m, s = {s}");
}

#[test]
fn motions_that_contradict_each_other_are_less_sure_than_they_say() {
    // Two motions of the same information, `apart_m` from each other: half of it is left of
    // each, so that χ² is apart_m² / 2, with three degrees of freedom more than before.
    let factor = |apart_m: f64| {
        let mut graph = PoseGraph::new(SE2::identity());
        graph.extend(&SE2::new(1.0, 0.0, 0.0), &Matrix3::identity());
        let other = SE2::new(1.0 + apart_m, 0.0, 0.0);
        graph.constrain(constraint(0, 1, other, Matrix3::identity(), Kind::Loop));
        graph.optimise().unwrap();
        graph.variance_factor()
    };
    assert_eq!(factor(1.0), 1.0);
    assert!((factor(4.0) - (9.0 + 8.0) / (0.3 * 33.0)).abs() < 1e-9, "{}", factor(4.0));
}

#[test]
fn what_is_not_determined_stays() {
    let mut graph = PoseGraph::new(SE2::new(1.0, 2.0, 3.0));
    assert_eq!((graph.to_last(&[]), graph.to_last(&[0])), (None, None));
    assert_eq!(graph.last_covariance(), Some(Matrix3::zeros()));
    graph.extend(&SE2::new(1.0, 0.0, 0.0), &Matrix3::zeros());
    let before = graph.poses().to_vec();
    assert_eq!(graph.optimise(), None);
    assert_eq!(graph.poses(), before);
}
