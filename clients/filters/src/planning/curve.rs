//! Curves of arcs and straight pieces, driven forwards or in reverse.

use nalgebra::Vector3;
use rusty_geometry::SE2;

/// A stretch of constant curvature.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Piece {
    /// Curvature, 1/m: positive to the left of the body, 0 on a straight line.
    pub curvature_per_m: f64,
    /// Length, m: negative where the piece is driven in reverse.
    pub length_m: f64,
}

impl Piece {
    /// Returns the motion over a share (0 to 1) of the piece, in the body frame at
    /// its start.
    pub fn motion(&self, share: f64) -> SE2 {
        let length_m = share * self.length_m;
        SE2::exp(&Vector3::new(length_m, 0.0, self.curvature_per_m * length_m))
    }

    /// Returns the motions to equally distant points of the piece, at most `step_m`
    /// (> 0) apart. The start is not among them, the end is.
    pub fn motions(&self, step_m: f64) -> impl Iterator<Item = SE2> + use<> {
        let (piece, count) = (*self, (self.length_m.abs() / step_m).ceil().max(1.0));
        (1..=count as u64).map(move |k| piece.motion(k as f64 / count))
    }
}

/// A curve in the world frame: pieces that follow each other without a corner.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Pose at the start, world frame.
    pub from: SE2,
    /// Pieces, from the start on.
    pub pieces: Vec<Piece>,
}

impl Curve {
    /// Joins pieces. Two that continue each other become one; those of length 0
    /// are left out.
    pub fn new(from: SE2, pieces: impl IntoIterator<Item = Piece>) -> Self {
        let mut joined: Vec<Piece> = Vec::new();
        for piece in pieces.into_iter().filter(|piece| piece.length_m != 0.0) {
            match joined.last_mut() {
                Some(last)
                    if last.curvature_per_m == piece.curvature_per_m
                        && (last.length_m < 0.0) == (piece.length_m < 0.0) =>
                {
                    last.length_m += piece.length_m;
                }
                _ => joined.push(piece),
            }
        }
        Self { from, pieces: joined }
    }

    /// Returns the length, m: reverse counts like forwards.
    pub fn length_m(&self) -> f64 {
        self.pieces.iter().map(|piece| piece.length_m.abs()).sum()
    }

    /// Returns the pose at a distance from the start along the curve; beyond an end
    /// the pose at this end.
    pub fn pose_at(&self, along_m: f64) -> SE2 {
        let (mut pose, mut left_m) = (self.from, along_m.max(0.0));
        for piece in &self.pieces {
            let length_m = piece.length_m.abs();
            if left_m < length_m {
                return pose.compose(&piece.motion(left_m / length_m));
            }
            pose = pose.compose(&piece.motion(1.0));
            left_m -= length_m;
        }
        pose
    }

    /// Returns the pose at the end.
    pub fn end(&self) -> SE2 {
        self.pose_at(f64::INFINITY)
    }

    /// Returns poses along the curve, at most `step_m` (> 0) apart; the ends of all
    /// pieces are among them.
    pub fn samples(&self, step_m: f64) -> impl Iterator<Item = SE2> {
        let mut next = self.from;
        let along = self.pieces.iter().flat_map(move |piece| {
            let start = next;
            next = start.compose(&piece.motion(1.0));
            piece.motions(step_m).map(move |motion| start.compose(&motion))
        });
        std::iter::once(self.from).chain(along)
    }

    /// Returns the number of changes between forwards and reverse.
    pub fn switches(&self) -> usize {
        let is_reverse = |piece: &Piece| piece.length_m < 0.0;
        self.pieces.windows(2).filter(|pair| is_reverse(&pair[0]) != is_reverse(&pair[1])).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    fn near(a: &SE2, b: &SE2) -> bool {
        a.boxminus(b).norm() < 1e-12
    }

    fn piece(curvature_per_m: f64, length_m: f64) -> Piece {
        Piece { curvature_per_m, length_m }
    }

    /// A quarter to the left, back as far to the right, and straight on.
    fn three() -> Curve {
        let pieces = [piece(2.0, 0.25 * PI), piece(-2.0, -0.25 * PI), piece(0.0, 1.0)];
        Curve::new(SE2::new(1.0, 2.0, 0.0), pieces)
    }

    #[test]
    fn poses_are_on_the_circles() {
        let curve = three();
        assert!(near(&curve.pose_at(0.25 * PI), &SE2::new(1.5, 2.5, FRAC_PI_2)));
        assert!(near(&curve.pose_at(0.5 * PI), &SE2::new(2.0, 2.0, PI)));
        assert!(near(&curve.end(), &SE2::new(1.0, 2.0, PI)));
        assert!(near(&curve.pose_at(0.5 * PI + 0.4), &SE2::new(1.6, 2.0, PI)));
        assert_eq!(curve.pose_at(-1.0), curve.from);
        assert_eq!(curve.pose_at(9.0), curve.end());
        assert!((curve.length_m() - 0.5 * PI - 1.0).abs() < 1e-12);
        assert_eq!(curve.switches(), 2);
    }

    #[test]
    fn samples_are_poses_of_the_curve_close_to_each_other() {
        let curve = three();
        let samples: Vec<SE2> = curve.samples(0.1).collect();
        assert_eq!(samples.len(), 1 + 8 + 8 + 10);
        assert!(near(&samples[16], &curve.pose_at(0.5 * PI)));
        assert!(near(&samples[26], &curve.end()));
        for pair in samples.windows(2) {
            assert!((pair[0].translation() - pair[1].translation()).norm() < 0.1 + 1e-12);
        }
    }

    #[test]
    fn pieces_that_continue_each_other_are_one() {
        let parts = [(1.0, 0.1), (1.0, 0.2), (0.0, 0.0), (1.0, -0.1), (0.0, -0.1), (0.0, -0.3)];
        let curve = Curve::new(SE2::identity(), parts.map(|(c, l)| piece(c, l)));
        assert_eq!(curve.pieces.len(), 3);
        assert_eq!(curve.switches(), 1);
        assert!((curve.length_m() - 0.8).abs() < 1e-12);
        let point = Curve::new(SE2::identity(), []);
        assert_eq!((point.length_m(), point.switches(), point.end()), (0.0, 0, point.from));
        assert_eq!(point.samples(0.1).count(), 1);
    }
}
