//! Long lines made short, and cut where nothing is known or nothing is drawn.
//!
//! Source of [`thin`]: D. Douglas and T. Peucker, *Algorithms for the reduction
//! of the number of points required to represent a digitized line or its
//! caricature* (1973). Departure: long lines are thinned piece by piece, which
//! keeps the worst case from growing with the square of their length.

use crate::canvas::{Px, Rect};

/// Most points a line is drawn with.
pub const MOST_POINTS: usize = 2000;
/// Largest invisible deviation from the true line, units of the page.
const UNSEEN: f64 = 0.25;
/// Points that [`thin`] looks at together.
const PIECE: usize = 512;

/// Splits samples (index of the tick, place) into the lines to draw: one breaks
/// where the estimates paused, that is, for more than five times the usual
/// distance between two of them. "Usual" is the 90th percentile, so that neither
/// an estimate every fifth tick nor a recording's uneven rhythm is a pause.
#[must_use]
pub fn runs(samples: &[(usize, [f64; 2])]) -> Vec<Vec<[f64; 2]>> {
    let mut gaps: Vec<usize> = samples.windows(2).map(|w| w[1].0.abs_diff(w[0].0)).collect();
    gaps.sort_unstable();
    let usual = gaps.get(gaps.len() * 9 / 10).copied().unwrap_or(1);
    let mut lines: Vec<Vec<[f64; 2]>> = Vec::new();
    let mut last = None;
    for &(tick, place) in samples {
        let goes_on = last.is_some_and(|last| tick.abs_diff(last) <= 5 * usual);
        match lines.last_mut() {
            Some(line) if goes_on => line.push(place),
            _ => lines.push(vec![place]),
        }
        last = Some(tick);
    }
    lines
}

/// The line with fewer points that looks the same, of at most [`MOST_POINTS`];
/// its ends stay.
#[must_use]
pub fn thin(line: &[Px]) -> Vec<Px> {
    let mut tolerance = UNSEEN;
    let mut thinned = thin_by(line, tolerance);
    while thinned.len() > MOST_POINTS && tolerance < 1e6 {
        tolerance *= 2.0;
        thinned = thin_by(&thinned, tolerance);
    }
    thinned
}

fn thin_by(line: &[Px], tolerance: f64) -> Vec<Px> {
    let Some((&first, _)) = line.split_first() else {
        return Vec::new();
    };
    let mut kept = vec![first];
    let mut start = 0;
    while start + 1 < line.len() {
        let end = (start + PIECE).min(line.len() - 1);
        thin_piece(&line[start..=end], tolerance, &mut kept);
        start = end;
    }
    kept
}

/// Adds what must stay of `piece` but its first point, which is there already.
fn thin_piece(piece: &[Px], tolerance: f64, kept: &mut Vec<Px>) {
    // Pieces still to be looked at, the nearest to the start on top.
    let mut open = vec![(0, piece.len() - 1)];
    while let Some((from, to)) = open.pop() {
        let (mut far, mut farthest) = (from, tolerance);
        for k in from + 1..to {
            let off = distance_to_segment(piece[k], piece[from], piece[to]);
            if off > farthest {
                (far, farthest) = (k, off);
            }
        }
        if far == from {
            kept.push(piece[to]);
        } else {
            open.push((far, to));
            open.push((from, far));
        }
    }
}

fn distance_to_segment(p: Px, a: Px, b: Px) -> f64 {
    let (abx, aby) = (b[0] - a[0], b[1] - a[1]);
    let (apx, apy) = (p[0] - a[0], p[1] - a[1]);
    let length2 = abx * abx + aby * aby;
    let along = if length2 > 0.0 { (apx * abx + apy * aby) / length2 } else { 0.0 };
    let along = along.clamp(0.0, 1.0);
    let (dx, dy) = (apx - along * abx, apy - along * aby);
    (dx * dx + dy * dy).sqrt()
}

/// A curve over time with at most two of each `bucket` points: the lowest and the
/// highest, so that no peak is lost; its ends stay.
#[must_use]
pub fn envelope(curve: &[[f64; 2]], bucket: usize) -> Vec<[f64; 2]> {
    if bucket < 3 {
        return curve.to_vec();
    }
    let mut kept: Vec<[f64; 2]> = curve.first().copied().into_iter().collect();
    for points in curve.chunks(bucket) {
        let (mut low, mut high) = (0, 0);
        for (k, point) in points.iter().enumerate() {
            if point[1] < points[low][1] {
                low = k;
            }
            if point[1] > points[high][1] {
                high = k;
            }
        }
        kept.push(points[low.min(high)]);
        kept.push(points[low.max(high)]);
    }
    kept.extend(curve.last());
    kept.dedup();
    kept
}

/// The parts of a line that are in `frame`, cut at its edges.
#[must_use]
pub fn clip(line: &[Px], frame: &Rect) -> Vec<Vec<Px>> {
    let mut parts: Vec<Vec<Px>> = Vec::new();
    for pair in line.windows(2) {
        let Some([from, to]) = clip_segment(pair[0], pair[1], frame) else {
            continue;
        };
        match parts.last_mut() {
            Some(part) if part.last() == Some(&from) => part.push(to),
            _ => parts.push(vec![from, to]),
        }
    }
    parts
}

/// The part of a segment in `frame` (Y.-D. Liang and B. Barsky, 1984).
fn clip_segment(a: Px, b: Px, frame: &Rect) -> Option<[Px; 2]> {
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for (toward, room) in [
        (-dx, a[0] - frame.left),
        (dx, frame.right - a[0]),
        (-dy, a[1] - frame.top),
        (dy, frame.bottom - a[1]),
    ] {
        if toward == 0.0 {
            if room < 0.0 {
                return None;
            }
        } else if toward < 0.0 {
            enter = enter.max(room / toward);
        } else {
            leave = leave.min(room / toward);
        }
    }
    // A comparison with NaN is false: such a segment is not drawn.
    if !(enter <= leave && dx.is_finite() && dy.is_finite()) {
        return None;
    }
    // Ends that are not cut keep their bits, so that parts join.
    let at = |t: f64| [a[0] + t * dx, a[1] + t * dy];
    let from = if enter > 0.0 { at(enter) } else { a };
    let to = if leave < 1.0 { at(leave) } else { b };
    Some([from, to])
}

#[cfg(test)]
mod tests {
    use super::*;
    use rusty_geometry::trig;

    const FRAME: Rect = Rect { left: 0.0, top: 0.0, right: 10.0, bottom: 10.0 };

    #[test]
    fn a_line_breaks_at_a_pause_and_not_at_a_rhythm() {
        let every = |step: usize, range: std::ops::Range<usize>| {
            range.map(move |k| (k * step, [k as f64, 0.0]))
        };
        let steady: Vec<_> = every(5, 0..100).collect();
        assert_eq!(runs(&steady).len(), 1);
        let uneven: Vec<_> = [0, 1, 4, 5, 8, 9, 12].map(|k| (k, [0.0, 0.0])).to_vec();
        assert_eq!(runs(&uneven).len(), 1);
        let paused: Vec<_> = every(1, 0..50).chain(every(1, 80..100)).collect();
        let lengths: Vec<usize> = runs(&paused).iter().map(Vec::len).collect();
        assert_eq!(lengths, [50, 20]);
        assert!(runs(&[]).is_empty());
        assert_eq!(runs(&[(7, [1.0, 2.0])]), [[[1.0, 2.0]]]);
    }

    #[test]
    fn a_thinned_line_stays_where_it_was() {
        let spiral: Vec<Px> = (0..14_000)
            .map(|k| {
                let angle_rad = f64::from(k) * 0.01;
                let (s, c) = trig::sin_cos(angle_rad);
                [300.0 + 2.0 * angle_rad * c, 300.0 + 2.0 * angle_rad * s]
            })
            .collect();
        let thinned = thin(&spiral);
        assert!((100..=MOST_POINTS).contains(&thinned.len()), "{}", thinned.len());
        assert_eq!((thinned.first(), thinned.last()), (spiral.first(), spiral.last()));
        for &p in spiral.iter().step_by(97) {
            let nearest = thinned
                .windows(2)
                .map(|w| distance_to_segment(p, w[0], w[1]))
                .fold(f64::INFINITY, f64::min);
            assert!(nearest <= 2.0 * UNSEEN, "{nearest}");
        }
        assert_eq!(thin(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]), [[0.0, 0.0], [2.0, 0.0]]);
        assert_eq!(thin(&[[1.0, 1.0]]), [[1.0, 1.0]]);
        assert!(thin(&[]).is_empty());
    }

    #[test]
    fn a_line_of_noise_is_thinned_as_well() {
        let noise: Vec<Px> =
            (0..30_000).map(|k| [f64::from(k % 771), f64::from(k * 7919 % 503)]).collect();
        assert!(thin(&noise).len() <= MOST_POINTS);
    }

    #[test]
    fn an_envelope_keeps_the_peaks() {
        let mut curve: Vec<[f64; 2]> = (0..14_000).map(|k| [f64::from(k), 0.0]).collect();
        curve[7_777][1] = 5.0;
        curve[12_345][1] = -3.0;
        let kept = envelope(&curve, 14);
        assert!(kept.len() <= MOST_POINTS + 2, "{}", kept.len());
        assert!(kept.contains(&[7777.0, 5.0]) && kept.contains(&[12_345.0, -3.0]));
        assert_eq!((kept.first(), kept.last()), (curve.first(), curve.last()));
        assert!(kept.windows(2).all(|w| w[0][0] < w[1][0]));
    }

    #[test]
    fn a_line_is_cut_at_the_frame() {
        let parts = clip(&[[5.0, 5.0], [15.0, 5.0], [15.0, 8.0], [5.0, 8.0], [5.0, 9.0]], &FRAME);
        assert_eq!(
            parts,
            [vec![[5.0, 5.0], [10.0, 5.0]], vec![[10.0, 8.0], [5.0, 8.0], [5.0, 9.0]]]
        );
        assert!(clip(&[[-5.0, -1.0], [20.0, -1.0]], &FRAME).is_empty());
        assert!(clip(&[[f64::NAN, 1.0], [2.0, 1.0]], &FRAME).is_empty());
        assert_eq!(clip(&[[-1e9, 5.0], [1e9, 5.0]], &FRAME).len(), 1);
    }
}
