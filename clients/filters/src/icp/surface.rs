//! The reference of a match: what a scan says of the walls around it.
//!
//! Every ray gets a piece of wall: a line fitted to it and its neighbours, as
//! many as lie on one line within the noise. At a corner the neighbours are
//! those of one side (M. Kuwahara's filter of 1976, on a line of points).

use nalgebra::{Point2, Vector2};
use rusty_geometry::SE2;

use super::laser::{Laser, Ray, View};

/// How many neighbours a line is fitted to, the most first.
const WINDOWS: [usize; 6] = [25, 17, 11, 7, 5, 3];
/// No piece of wall is longer, m: what is longer is seen in several.
const LONGEST_M: f64 = 2.0;
/// The most beams without an end between two neighbours.
const MISSING_BEAMS: usize = 2;
/// A direction less certain than this (rad, one deviation) is none.
const WORST_TILT_RAD: f64 = 0.15;

/// A piece of wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// Middle of the points it was fitted to, body frame of the scan, m.
    pub middle: Point2<f64>,
    /// Towards the sensor, length 1.
    pub normal: Vector2<f64>,
    /// Along the wall, length 1.
    pub tangent: Vector2<f64>,
    /// Where it begins and ends along the tangent, from the middle, m.
    pub extent_m: [f64; 2],
    /// Variance of the normal's direction, rad².
    pub tilt_variance: f64,
    /// Covariance of the line's slope and its height in the middle, m: not zero where the
    /// angle of incidence changes along the piece.
    tilt_height_m: f64,
    /// Mean variance of the points across the line, m².
    pub variance_m2: f64,
    /// Sum of the squared distances of the points from the middle, m².
    spread_m2: f64,
    /// The first of the rays it was fitted to, and how many there are.
    window: (usize, usize),
}

impl Piece {
    /// Weight of the ray at `along_m` in the height of the line at `at_m`
    /// (ordinary least squares): heights are Σ weight · height of the ray.
    fn weight(&self, at_m: f64, along_m: f64) -> f64 {
        1.0 / self.window.1 as f64 + at_m * along_m / self.spread_m2
    }

    /// Variance of the height of the line at `at_m`, m².
    pub fn height_variance_m2(&self, at_m: f64) -> f64 {
        let in_middle_m2 = self.variance_m2 / self.window.1 as f64;
        in_middle_m2 + (2.0 * self.tilt_height_m + self.tilt_variance * at_m) * at_m
    }

    /// Covariance of the line's slope and its height at `at_m`, m.
    pub(super) fn slope_with_height_m(&self, at_m: f64) -> f64 {
        self.tilt_height_m + self.tilt_variance * at_m
    }
}

/// The side from which a wall is seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The side that its scan saw.
    Front,
    /// The other one.
    Behind,
}

/// By what the nearest piece of wall is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Nearest {
    /// By the distance from the piece.
    ByDistance,
    /// Of pieces that fit about as well, the one whose middle is nearest. The one that fits
    /// best has the error of the point, and a scan would seem to match wherever it is.
    ByMiddle,
}

/// The walls around a scan.
#[derive(Clone, Debug)]
pub struct Surface {
    view: View,
    rays: Vec<Ray>,
    pieces: Vec<Piece>,
    /// Of each beam the piece of wall that it met.
    of_beam: Vec<Option<usize>>,
    range_std_m: f64,
    roughness_m: f64,
}

impl Surface {
    /// Fits pieces of wall to the ends of a scan. Walls are rough by
    /// `roughness_m` (one deviation), whatever the laser's noise.
    pub fn new(laser: &Laser, rays: &[Ray], roughness_m: f64) -> Self {
        let view = laser.view();
        let mut surface = Self {
            view,
            rays: rays.to_vec(),
            pieces: Vec::new(),
            of_beam: vec![None; view.beams],
            range_std_m: laser.range_std_m,
            roughness_m,
        };
        for (k, ray) in rays.iter().enumerate() {
            if let Some(piece) = surface.piece_at(k) {
                surface.of_beam[ray.beam] = Some(surface.pieces.len());
                surface.pieces.push(piece);
            }
        }
        surface
    }

    /// The pieces of wall, in the order of the beams that met them.
    pub fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    /// The piece of wall that one of the rays met.
    pub(super) fn piece_of(&self, ray: &Ray) -> Option<&Piece> {
        self.of_beam[ray.beam].map(|k| &self.pieces[k])
    }

    /// The rays they were fitted to.
    pub fn rays(&self) -> &[Ray] {
        &self.rays
    }

    /// Variance of a range, m².
    pub(super) fn range_variance_m2(&self) -> f64 {
        self.range_std_m * self.range_std_m
    }

    /// Variance of a ray's end across a wall with this normal, m².
    pub(super) fn variance_m2(&self, direction: &Vector2<f64>, normal: &Vector2<f64>) -> f64 {
        let across_m = self.range_std_m * direction.dot(normal);
        across_m * across_m + self.roughness_m * self.roughness_m
    }

    /// Of each ray that a piece was fitted to: its number, and how much the
    /// height of the line at `at_m` moves with one deviation of its error, m.
    pub(super) fn levers(
        &self,
        piece: usize,
        at_m: f64,
    ) -> impl Iterator<Item = (usize, f64)> + '_ {
        let piece = &self.pieces[piece];
        self.window(piece.window).map(move |k| {
            let ray = &self.rays[k];
            let along_m = (ray.point - piece.middle).dot(&piece.tangent);
            let deviation_m = self.variance_m2(&ray.direction, &piece.normal).sqrt();
            (k, piece.weight(at_m, along_m) * deviation_m)
        })
    }

    /// Whether this scan looked where the point is.
    pub(super) fn looks_at(&self, point: &Point2<f64>) -> bool {
        self.view.has(self.view.beam_towards(point))
    }

    /// Whether a ray from the pose `now` ends within `reach_m` of a wall, seen from this side.
    pub fn has_wall(&self, ray: &Ray, now: &SE2, reach_m: f64, side: Side) -> bool {
        let [point, viewpoint] = [ray.point, self.view.viewpoint].map(|p| now.transform_point(&p));
        self.nearest(&point, &viewpoint, reach_m, side, Nearest::ByDistance).is_some()
    }

    /// The piece of wall nearest to a point that was seen from `viewpoint`, from this side of
    /// the wall, no farther than `reach_m`, and how far along it from its middle, m.
    pub(super) fn nearest(
        &self,
        point: &Point2<f64>,
        viewpoint: &Point2<f64>,
        reach_m: f64,
        side: Side,
        by: Nearest,
    ) -> Option<(usize, f64)> {
        let beam = self.view.beam_towards(point);
        // A wall within reach is seen under no larger angle than this.
        let away_m = self.view.distance_m(point);
        let angle = if away_m > reach_m { 1.6 * reach_m / away_m } else { std::f64::consts::PI };
        let beams = (angle / self.view.step_rad).ceil() as usize + 1;
        let noise_m2 = match by {
            Nearest::ByDistance => 0.0,
            Nearest::ByMiddle => self.range_variance_m2() + self.roughness_m * self.roughness_m,
        };
        let (mut best, mut best_m2) = (None, f64::INFINITY);
        for beam in self.view.around(beam, beams) {
            let Some(k) = self.of_beam[beam] else { continue };
            let piece = &self.pieces[k];
            let offset = point - piece.middle;
            let (along_m, across_m) = (offset.dot(&piece.tangent), offset.dot(&piece.normal));
            let [from_m, to_m] = piece.extent_m;
            let beyond_m = (from_m - along_m).max(along_m - to_m).max(0.0);
            // The gap to the next beam's end belongs to the wall as well.
            let gap_m = 0.5 * (to_m - from_m) / (piece.window.1 - 1) as f64;
            let beyond_m = (beyond_m - gap_m).max(0.0);
            let squared_m2 = across_m * across_m + beyond_m * beyond_m;
            let is_front = (viewpoint - piece.middle).dot(&piece.normal) > 0.0;
            let counts = is_front == (side == Side::Front) && beyond_m <= gap_m;
            let beams_off = along_m / (2.0 * gap_m);
            let sum_m2 = squared_m2 + noise_m2 * beams_off * beams_off;
            if counts && squared_m2 < reach_m * reach_m && sum_m2 < best_m2 {
                (best, best_m2) = (Some((k, along_m)), sum_m2);
            }
        }
        best
    }

    fn window(
        &self,
        (first, count): (usize, usize),
    ) -> impl Iterator<Item = usize> + Clone + use<> {
        let all = self.rays.len();
        (first..first + count).map(move |k| k % all)
    }

    /// Whether ray `k` and the next one are neighbours.
    fn are_linked(&self, k: usize) -> bool {
        let next = (k + 1) % self.rays.len();
        let apart = self.rays[next].beam as i64 - self.rays[k].beam as i64;
        let beams = self.view.beams as i64;
        let apart = if self.view.wraps { apart.rem_euclid(beams) } else { apart };
        (1..=1 + MISSING_BEAMS as i64).contains(&apart)
    }

    /// How many rays in a row have ray `k` for a neighbour of a neighbour, before
    /// and after it.
    fn reach(&self, k: usize) -> [usize; 2] {
        let all = self.rays.len();
        let most = (WINDOWS[0] - 1).min(all - 1);
        let before = (0..most).take_while(|i| self.are_linked((k + 2 * all - 1 - i) % all)).count();
        let after = (0..most).take_while(|i| self.are_linked((k + i) % all)).count();
        [before, after]
    }

    /// The piece of wall that ray `k` met: the most neighbours that fit a line,
    /// and of those the side that fits it best.
    fn piece_at(&self, k: usize) -> Option<Piece> {
        let all = self.rays.len();
        let [before, after] = self.reach(k);
        for count in WINDOWS.into_iter().filter(|count| *count <= all) {
            let sides = [count / 2, 0, count - 1].into_iter();
            let fits = sides.filter(|back| *back <= before && count - 1 - back <= after);
            let fits = fits.filter_map(|back| self.fit(((k + all - back) % all, count)));
            let best = fits.min_by(|(a, _), (b, _)| a.total_cmp(b));
            if let Some((_, piece)) = best {
                return Some(piece);
            }
        }
        None
    }

    /// The line through some rays, and how well it fits; `None` where it does
    /// not, or says nothing.
    fn fit(&self, window: (usize, usize)) -> Option<(f64, Piece)> {
        let (count, points) = (window.1 as f64, self.window(window));
        let sum: Vector2<f64> = points.clone().map(|k| self.rays[k].point.coords).sum();
        let middle = Point2::from(sum / count);
        let (mut xx, mut xy, mut yy) = (0.0f64, 0.0f64, 0.0f64);
        // Noise of the ranges stretches the points along the beams; that is taken off.
        let noise_m2 = (1.0 - 1.0 / count) * self.range_variance_m2();
        for k in points.clone() {
            let (d, r) = (self.rays[k].point - middle, self.rays[k].direction);
            xx += d.x * d.x - noise_m2 * r.x * r.x;
            xy += d.x * d.y - noise_m2 * r.x * r.y;
            yy += d.y * d.y - noise_m2 * r.y * r.y;
        }
        // Eigenvectors of the scatter, without an angle: the long one.
        let spread_m2 = 0.5 * (xx + yy) + (0.25 * (xx - yy) * (xx - yy) + xy * xy).sqrt();
        let tangent = if xx >= yy {
            Vector2::new(spread_m2 - yy, xy)
        } else {
            Vector2::new(xy, spread_m2 - xx)
        };
        let tangent = tangent.try_normalize(1e-12)?;
        let mut normal = Vector2::new(-tangent.y, tangent.x);
        if (self.view.viewpoint - middle).dot(&normal) < 0.0 {
            normal = -normal;
        }
        let (mut from_m, mut to_m, mut chi2, mut variance_m2) = (0.0f64, 0.0f64, 0.0, 0.0);
        let (mut tilt_variance, mut tilt_height_m) = (0.0, 0.0);
        for k in points {
            let ray = &self.rays[k];
            let offset = ray.point - middle;
            let (along_m, across_m) = (offset.dot(&tangent), offset.dot(&normal));
            let of_ray_m2 = self.variance_m2(&ray.direction, &normal);
            let squared = across_m * across_m / of_ray_m2;
            if squared > 9.0 {
                return None;
            }
            (from_m, to_m) = (from_m.min(along_m), to_m.max(along_m));
            (chi2, variance_m2) = (chi2 + squared, variance_m2 + of_ray_m2 / count);
            let lever = along_m / spread_m2;
            tilt_variance += lever * lever * of_ray_m2;
            tilt_height_m += lever * of_ray_m2 / count;
        }
        let free = count - 2.0;
        let is_line = chi2 <= free + 2.5 * (2.0 * free).sqrt();
        let is_told = tilt_variance <= WORST_TILT_RAD * WORST_TILT_RAD;
        if !(is_line && is_told) || (to_m - from_m > LONGEST_M && window.1 > 3) {
            return None;
        }
        let extent_m = [from_m, to_m];
        Some((
            chi2 / free,
            Piece {
                middle,
                normal,
                tangent,
                extent_m,
                tilt_variance,
                tilt_height_m,
                variance_m2,
                spread_m2,
                window,
            },
        ))
    }
}
