//! Four beams next to each other, and the first wall that each has met so far.

use super::lanes::{BEAMS, Pack};

/// A number for each beam.
type Lanes = [f64; BEAMS];

/// Four beams. Where a scan has fewer, a lane points nowhere (NaN) and its
/// distance is −∞, which nothing can improve.
#[derive(Clone, Debug)]
#[repr(align(32))]
pub(super) struct Group {
    /// Direction in the sensor frame, a unit vector.
    in_sensor_x: Lanes,
    in_sensor_y: Lanes,
    /// Direction in the world frame.
    x: Lanes,
    y: Lanes,
    /// Distance to the first wall, m; the maximum while none is met.
    pub t: Lanes,
    /// Index of that wall; infinite while none is met.
    pub index: Lanes,
}

/// A wall as the sensor sees it: its ends relative to the sensor, world axes.
#[derive(Clone, Copy)]
pub(super) struct Seen<F: Pack> {
    pub a_x: F,
    pub a_y: F,
    pub b_x: F,
    pub b_y: F,
    /// Whether b is to the left of a: the sign of c, which is not 0 where the
    /// wall passes the sensor.
    pub left: F::Mask,
    pub index: F,
}

impl Group {
    /// Four beams that point nowhere.
    pub fn nowhere() -> Self {
        let (none, nothing) = ([f64::NAN; BEAMS], [f64::NEG_INFINITY; BEAMS]);
        let index = [f64::INFINITY; BEAMS];
        Self { in_sensor_x: none, in_sensor_y: none, x: none, y: none, t: nothing, index }
    }

    /// Points a beam along a unit vector of the sensor frame.
    pub fn point(&mut self, lane: usize, x: f64, y: f64) {
        (self.in_sensor_x[lane], self.in_sensor_y[lane]) = (x, y);
        self.t[lane] = f64::INFINITY;
    }

    /// Direction of a beam in the world frame, a unit vector.
    pub fn direction(&self, lane: usize) -> [f64; 2] {
        [self.x[lane], self.y[lane]]
    }

    /// Turns the beams by an angle and forgets what they met.
    #[inline(always)]
    pub fn aim<F: Pack<Number = f64, Array = Lanes>>(
        &mut self,
        token: F::Token,
        sin: f64,
        cos: f64,
        max_m: f64,
    ) {
        let (sin, cos, nothing) =
            (F::all(token, sin), F::all(token, cos), F::all(token, f64::NEG_INFINITY));
        let (x, y) = (F::load(token, &self.in_sensor_x), F::load(token, &self.in_sensor_y));
        self.x = (cos * x - sin * y).store();
        self.y = (sin * x + cos * y).store();
        self.t =
            F::choose(F::load(token, &self.t).eq(nothing), nothing, F::all(token, max_m)).store();
        self.index = [f64::INFINITY; BEAMS];
    }

    /// Whether a wall that is nowhere nearer than `bound` can matter to any of
    /// the four. At equal distance it can: the index decides.
    #[inline(always)]
    pub fn sees<F: Pack<Number = f64, Array = Lanes>>(&self, bound: F) -> bool {
        F::bits(bound.le(F::load(bound.token(), &self.t))) != 0
    }

    /// Puts a wall to the four beams: rules 1 and 4 of [`crate::wall`], with its
    /// operations in its order. Returns whether a beam meets an end exactly;
    /// rules 2 and 3 are then for the caller, and the lane is left as it was.
    #[inline(always)]
    pub fn meet<F: Pack<Number = f64, Array = Lanes>>(&mut self, wall: &Seen<F>) -> bool {
        let token = wall.a_x.token();
        let zero = F::all(token, 0.0);
        let (x, y) = (F::load(token, &self.x), F::load(token, &self.y));
        let s_a = x * wall.a_y - y * wall.a_x;
        let s_b = x * wall.b_y - y * wall.b_x;
        let p_a = x * wall.a_x + y * wall.a_y;
        let p_b = x * wall.b_x + y * wall.b_y;
        let (w_a, w_b) = (s_a.abs(), s_b.abs());
        let t = ((p_a * w_b + p_b * w_a) / (w_a + w_b)).max(zero);
        let at_end = s_a.eq(zero) | s_b.eq(zero);
        let (a_left, b_left) = (zero.lt(s_a), zero.lt(s_b));
        let (a_ahead, b_ahead) = (zero.le(p_a), zero.le(p_b));
        let before = (a_ahead & b_ahead) | ((a_ahead | b_ahead) & !(b_left ^ wall.left));
        let hit = (a_left ^ b_left) & !at_end & before;
        let (t_so_far, index_so_far) = (F::load(token, &self.t), F::load(token, &self.index));
        let tie = t.eq(t_so_far) & wall.index.lt(index_so_far);
        let better = hit & (t.lt(t_so_far) | tie);
        self.t = F::choose(better, t, t_so_far).store();
        self.index = F::choose(better, wall.index, index_so_far).store();
        F::bits(at_end) != 0
    }

    /// Takes a hit of a beam that came about otherwise.
    pub fn offer(&mut self, lane: usize, t: f64, index: f64) {
        if t < self.t[lane] || (t == self.t[lane] && index < self.index[lane]) {
            (self.t[lane], self.index[lane]) = (t, index);
        }
    }
}
