//! The fit itself: components of variance by the method of scoring.

use nalgebra::{Matrix2, Matrix4, Vector4};
use rusty_geometry::trig;

use super::{Alpha, Identifiability, MotionFit, Systematic, Window, Windows};

/// It stops once no α moves by more than this of its standard error.
const SETTLED: f64 = 1e-6;
const MOST_ROUNDS: usize = 200;
/// Two α of which only a sum is told apart this badly: their errors are this many
/// times those that each would have alone.
const ENTANGLED: f64 = 1e3;

/// Log likelihood, slope, expected and observed information at some α.
struct Look {
    log_likelihood: f64,
    slope: Vector4<f64>,
    expected: Matrix4<f64>,
    observed: Matrix4<f64>,
}

fn covariance(window: &Window, alphas: &Vector4<f64>) -> Matrix2<f64> {
    let sum = window.of_alpha.iter().zip(alphas.iter()).map(|(of, alpha)| of * *alpha);
    sum.fold(window.known, |all, one| all + one)
}

fn look(windows: &[Window], alphas: &Vector4<f64>) -> Look {
    let (mut slope, mut log_likelihood) = (Vector4::zeros(), 0.0);
    let (mut expected, mut observed) = (Matrix4::zeros(), Matrix4::zeros());
    for window in windows {
        let s = covariance(window, alphas);
        let determinant = s[(0, 0)] * s[(1, 1)] - s[(0, 1)] * s[(1, 0)];
        if determinant <= 0.0 || !determinant.is_finite() {
            continue;
        }
        let inverse = Matrix2::new(s[(1, 1)], -s[(0, 1)], -s[(1, 0)], s[(0, 0)]) / determinant;
        let weighted = inverse * window.error;
        log_likelihood -= 0.5 * (trig::ln(determinant) + window.error.dot(&weighted));
        let by = window.of_alpha.map(|of| inverse * of);
        let pulled = window.of_alpha.map(|of| of * weighted);
        for j in 0..4 {
            slope[j] += 0.5 * (weighted.dot(&pulled[j]) - by[j].trace());
            for k in 0..=j {
                let both = 0.5 * (by[j] * by[k]).trace();
                let seen = pulled[j].dot(&(inverse * pulled[k])) - both;
                expected[(j, k)] += both;
                observed[(j, k)] += seen;
            }
        }
    }
    expected.fill_upper_triangle_with_lower_triangle();
    observed.fill_upper_triangle_with_lower_triangle();
    Look { log_likelihood, slope, expected, observed }
}

/// The inverse of an information, of those that are `wanted` alone; `None` if it
/// is none. Its numbers are of very different sizes, so it is scaled first.
fn inverse(information: &Matrix4<f64>, wanted: [bool; 4], ridge: f64) -> Option<Matrix4<f64>> {
    let scale = |k: usize| information[(k, k)].sqrt().recip();
    let scaled = Matrix4::from_fn(|j, k| match (wanted[j] && wanted[k], j == k) {
        (true, same) => information[(j, k)] * scale(j) * scale(k) + if same { ridge } else { 0.0 },
        (false, same) => f64::from(u8::from(same)),
    });
    let inverse = scaled.cholesky()?.inverse();
    let back = |k: usize| if wanted[k] { scale(k) } else { 0.0 };
    let inverse = Matrix4::from_fn(|j, k| inverse[(j, k)] * back(j) * back(k));
    inverse.iter().all(|v| v.is_finite()).then_some(inverse)
}

/// Where all the error of heading comes from the first two, half from each, and
/// all of the way's from the others.
fn first_guess(windows: &[Window]) -> Vector4<f64> {
    Vector4::from_fn(|k, _| {
        let axis = usize::from(k < 2);
        let errors: f64 = windows.iter().map(|w| w.error[axis] * w.error[axis]).sum();
        let of_one: f64 = windows.iter().map(|w| w.of_alpha[k][(axis, axis)]).sum();
        if of_one > 0.0 { 0.5 * errors / of_one } else { 0.0 }
    })
}

/// Fits the four α; `None` if there is no window.
pub fn fit(windows: &Windows) -> Option<MotionFit> {
    let all = &windows.all[..];
    if all.is_empty() {
        return None;
    }
    let mut alphas = first_guess(all);
    let mut here = look(all, &alphas);
    let informs: [bool; 4] = std::array::from_fn(|k| here.expected[(k, k)] > 0.0);
    let (mut rounds, mut converged) = (vec![here.log_likelihood], false);
    while rounds.len() <= MOST_ROUNDS && !converged {
        let at_edge = |k: usize| alphas[k] <= 0.0 && here.slope[k] <= 0.0;
        let wanted = std::array::from_fn(|k| informs[k] && !at_edge(k));
        let inverse = inverse(&here.expected, wanted, 1e-12)
            .or_else(|| inverse(&here.expected, wanted, 1e-6));
        // No way up is known: it is not said that this is the top.
        let Some(inverse) = inverse else { break };
        let step = inverse * here.slope;
        let (mut next, mut there) = (alphas, None);
        for halved in 0..40 {
            let share = 1.0 / (1_u64 << halved) as f64;
            next = (alphas + step * share).map(|alpha| alpha.max(0.0));
            let found = look(all, &next);
            if found.log_likelihood >= here.log_likelihood {
                there = Some(found);
                break;
            }
        }
        // Not a step up however short: it is at the top.
        let Some(found) = there else {
            converged = true;
            break;
        };
        let moved = (0..4).map(|k| (next[k] - alphas[k]).abs() * here.expected[(k, k)].sqrt());
        converged = moved.fold(0.0, f64::max) < SETTLED;
        (alphas, here) = (next, found);
        rounds.push(here.log_likelihood);
    }
    let ticks: u64 = all.iter().map(|w| w.ticks).sum();
    let [turn_per_m, turn_per_rad] = systematic_turn(all, &alphas);
    Some(MotionFit {
        alphas: errors(&alphas, &here, informs),
        windows: all.len(),
        ticks_a_window: ticks as f64 / all.len() as f64,
        left: windows.left,
        rounds,
        converged,
        ahead_per_m: systematic_way(all, &alphas),
        turn_per_m,
        turn_per_rad,
    })
}

fn errors(alphas: &Vector4<f64>, at: &Look, informs: [bool; 4]) -> [Alpha; 4] {
    let (information, covariance) = match inverse(&at.observed, informs, 0.0) {
        Some(covariance) => (at.observed, Some(covariance)),
        None => (at.expected, inverse(&at.expected, informs, 0.0)),
    };
    std::array::from_fn(|k| {
        let value = alphas[k];
        let std_error = covariance.filter(|_| informs[k]).map(|c| c[(k, k)].sqrt());
        let entangled = |e: &f64| e * information[(k, k)].sqrt() > ENTANGLED;
        match std_error.filter(|e| !entangled(e)) {
            None => Alpha { value, std_error: None, told: Identifiability::Not },
            Some(e) if value > 2.0 * e => Alpha { value, std_error, told: Identifiability::Well },
            Some(_) => Alpha { value, std_error, told: Identifiability::Hardly },
        }
    })
}

/// Error ahead per metre, by least squares.
fn systematic_way(windows: &[Window], alphas: &Vector4<f64>) -> Option<Systematic> {
    let (mut information, mut sum) = (0.0, 0.0);
    for window in windows {
        let weight = covariance(window, alphas)[(0, 0)].recip();
        information += weight * window.driven.x * window.driven.x;
        sum += weight * window.driven.x * window.error.x;
    }
    let is_told = information > 0.0 && f64::is_finite(information);
    is_told.then(|| Systematic { value: sum / information, std_error: information.sqrt().recip() })
}

/// Error of heading per metre and per radian, by least squares for both.
fn systematic_turn(windows: &[Window], alphas: &Vector4<f64>) -> [Option<Systematic>; 2] {
    let (mut information, mut sum) = (Matrix2::zeros(), nalgebra::Vector2::zeros());
    for window in windows {
        let weight = covariance(window, alphas)[(1, 1)].recip();
        information += window.driven * window.driven.transpose() * weight;
        sum += window.driven * (weight * window.error.y);
    }
    let is_told = [0, 1].map(|k| information[(k, k)] > 0.0);
    for k in (0..2).filter(|k| !is_told[*k]) {
        information[(k, k)] = 1.0;
    }
    let Some(covariance) = information.cholesky().map(|c| c.inverse()) else { return [None; 2] };
    let value = covariance * sum;
    [0, 1].map(|k| {
        let std_error = covariance[(k, k)].sqrt();
        is_told[k].then_some(Systematic { value: value[k], std_error })
    })
}
