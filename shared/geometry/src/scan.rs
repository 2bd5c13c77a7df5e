//! A scan: many rays from one point, cast as one problem.
//!
//! [`World::raycast_dir`] asks the tree of walls once per ray. A scan asks it
//! once: walls near first, each put to the beams between the bearings of its
//! ends that do not already see something nearer. One pass over eight walls gives
//! their distances and sectors, one pass over four beams puts a wall to them.
//!
//! **The same bits.** Distance and wall of every beam are those of
//! [`World::raycast_dir`] along the same direction, to the last bit: the formula
//! of [`crate::wall`] decides, with its operations in its order, and ties go to
//! the lowest index, in whatever order walls are taken. All else only leaves out
//! pairs of wall and beam that provably cannot matter, see `scan/sector.rs`.
//!
//! Source: the idea is the depth buffer (E. Catmull, 1974) over bearings, with
//! occlusion culling front to back over a hierarchy (N. Greene, M. Kass,
//! G. Miller, *Hierarchical Z-buffer visibility*, SIGGRAPH 1993).
//!
//! Departures from "one tree for everything": a scan has a separate tree, whose
//! leaves are blocks of eight walls. `parry2d`'s, which single rays and bodies
//! use, ends in single walls behind an index.

mod group;
mod lanes;
mod plain;
mod sector;
#[cfg(target_arch = "x86_64")]
mod wide;

use core::f64::consts::TAU;
use core::ops::Range;

use nalgebra::{Point2, Vector2};

use self::group::{Group, Seen};
use self::lanes::{BEAMS, Pack, Rough, WALLS, Way};
use self::plain::Plain;
use self::sector::{Bearings, EightBoxes, EightWalls, Span};
use crate::avx2::Avx2;
use crate::fan::Fan;
use crate::se2::SE2;
use crate::trig;
use crate::wall_blocks::{Below, Block, Octet};
use crate::world::{Hit, World};

/// Something still to be looked at: a box with walls in it.
#[derive(Clone, Copy, Debug)]
struct Ahead {
    below: Below,
    /// The beams that can meet anything in it.
    span: Span,
    /// None of them nearer than this, m.
    bound: f32,
}

/// A fan of beams and what they meet.
///
/// Made once, then [`take`](Self::take)n as often as one likes; taking a scan
/// allocates nothing after the first ones. What a scan holds does not depend on
/// the ones before it.
#[derive(Clone, Debug)]
pub struct Scan {
    fan: Fan,
    groups: Vec<Group>,
    /// Groups of beams per radian of bearing.
    groups_per_rad: f32,
    /// Boxes to look into, the nearest on top.
    ahead: Vec<Ahead>,
    /// The processor's vectors of four, if they are to be used.
    #[cfg_attr(not(target_arch = "x86_64"), expect(dead_code, reason = "only x86-64 has AVX2"))]
    avx2: Option<Avx2>,
}

impl Scan {
    /// A scan with these beams, before the first is taken.
    #[must_use]
    pub fn new(fan: Fan) -> Self {
        let beams = fan.beams as usize;
        let mut groups = vec![Group::nowhere(); beams.div_ceil(BEAMS)];
        for k in 0..fan.beams {
            let (group, lane) = (&mut groups[k as usize / BEAMS], k as usize % BEAMS);
            let direction = fan.direction(k);
            group.point(lane, direction.x, direction.y);
        }
        let groups_per_rad = (f64::from(fan.beams) / (fan.fov_rad * BEAMS as f64)) as f32;
        Self { fan, groups, groups_per_rad, ahead: Vec::with_capacity(64), avx2: Avx2::detect() }
    }

    /// The same, but with the instructions that every machine of this kind has,
    /// for measurements that must not depend on the machine. The bits are equal.
    #[must_use]
    pub fn portable(fan: Fan) -> Self {
        Self { avx2: None, ..Self::new(fan) }
    }

    /// The beams.
    #[must_use]
    pub fn fan(&self) -> &Fan {
        &self.fan
    }

    /// Looks around in `world` from the sensor pose `sensor_in_world`, no
    /// farther than `max_m`. A wall at exactly `max_m` is met; a sensor on a wall
    /// reads 0 in every direction; from a pose that is not finite nothing is met.
    pub fn take(&mut self, world: &World, sensor_in_world: &SE2, max_m: f64) {
        let origin = Point2::from(sensor_in_world.translation());
        let (sin, cos) = trig::sin_cos(sensor_in_world.theta());
        let base_rad = (sensor_in_world.theta() + self.fan.first_bearing_rad).rem_euclid(TAU);
        let bearings = Bearings {
            base_rad: base_rad as f32,
            groups_per_rad: self.groups_per_rad,
            groups: self.groups.len() as f32,
        };
        let max_rough_m = (max_m * (1.0 + 1e-6)) as f32;
        let view = View { world, origin, sin, cos, bearings, max_m, max_rough_m };
        if !view.is_tame() {
            self.take_by_rays(&view);
            return;
        }
        #[cfg(target_arch = "x86_64")]
        if let Some(avx2) = self.avx2 {
            // SAFETY: the processor has AVX2, as `avx2` proves.
            unsafe { self.take_wide(avx2, &view) };
            return;
        }
        self.take_lanes(Plain, &view);
    }

    /// [`take_lanes`](Self::take_lanes), compiled for four lanes at a time.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn take_wide(&mut self, avx2: Avx2, view: &View<'_>) {
        self.take_lanes(avx2, view);
    }

    #[inline(always)]
    fn take_lanes<W: Way>(&mut self, way: W, view: &View<'_>) {
        for group in &mut self.groups {
            group.aim::<W::Exact>(way, view.sin, view.cos, view.max_m);
        }
        let all = view.world.wall_blocks();
        self.ahead.clear();
        if let Some(root) = all.octets.first() {
            self.look_into(way, view, root);
        }
        while let Some(next) = self.ahead.pop() {
            if self.is_hidden(way, &next) {
                continue;
            }
            match next.below.block() {
                Some(place) => self.meet_block(way, view, &all.blocks[place]),
                None => self.look_into(way, view, &all.octets[next.below.octet()]),
            }
        }
    }

    /// Whether nothing in a box can matter to any beam.
    #[inline(always)]
    fn is_hidden<W: Way>(&self, way: W, next: &Ahead) -> bool {
        let (first, again) = self.ranges(next.span);
        let bound = W::Exact::all(way, f64::from(next.bound));
        let sees = |groups: &[Group]| groups.iter().any(|group| group.sees(bound));
        !sees(&self.groups[first]) && !sees(&self.groups[again])
    }

    #[inline(always)]
    fn ranges(&self, span: Span) -> (Range<usize>, Range<usize>) {
        let last = self.groups.len();
        let to = (span.to as usize).min(last);
        ((span.from as usize).min(to)..to, 0..(span.again as usize).min(last))
    }

    /// Puts eight boxes on the list of what is ahead, the nearest on top.
    #[inline(always)]
    fn look_into<W: Way>(&mut self, way: W, view: &View<'_>, octet: &Octet) {
        let (x, y) = (view.origin.x, view.origin.y);
        let boxes = EightBoxes::new(
            W::Rough::differences(way, &octet.x_lo, x),
            W::Rough::differences(way, &octet.y_lo, y),
            W::Rough::differences(way, &octet.x_hi, x),
            W::Rough::differences(way, &octet.y_hi, y),
        );
        let spans = boxes.spans(&view.bearings);
        // False for NaN, too: no box in this lane.
        let mut in_reach = W::Rough::bits(boxes.bound.le(W::Rough::all(way, view.max_rough_m)));
        let bounds = boxes.bound.store();
        let bottom = self.ahead.len();
        while in_reach != 0 {
            let lane = in_reach.trailing_zeros() as usize & (WALLS - 1);
            in_reach &= in_reach - 1;
            let next =
                Ahead { below: octet.below[lane], span: spans.get(lane), bound: bounds[lane] };
            self.ahead.push(next);
            let mut place = self.ahead.len() - 1;
            while place > bottom && self.ahead[place - 1].bound < next.bound {
                self.ahead[place] = self.ahead[place - 1];
                place -= 1;
            }
            self.ahead[place] = next;
        }
    }

    /// Puts eight walls to the beams they can matter to.
    #[inline(always)]
    fn meet_block<W: Way>(&mut self, way: W, view: &View<'_>, block: &Block) {
        let (x, y) = (view.origin.x, view.origin.y);
        let walls = EightWalls::new(
            W::Rough::differences(way, &block.a_x, x),
            W::Rough::differences(way, &block.a_y, y),
            W::Rough::differences(way, &block.b_x, x),
            W::Rough::differences(way, &block.b_y, y),
        );
        let spans = walls.spans(&view.bearings);
        // False for NaN, too: no wall in this lane.
        let mut in_reach = W::Rough::bits(walls.bound.le(W::Rough::all(way, view.max_rough_m)));
        let here = W::Rough::bits(walls.here);
        let bounds = walls.bound.store();
        while in_reach != 0 {
            let k = in_reach.trailing_zeros() as usize & (WALLS - 1);
            in_reach &= in_reach - 1;
            if here >> k & 1 != 0 {
                self.meet_exactly(view, block.index[k], 0..self.groups.len());
                continue;
            }
            let (a_x, a_y) = (block.a_x[k] - x, block.a_y[k] - y);
            let (b_x, b_y) = (block.b_x[k] - x, block.b_y[k] - y);
            let seen = Seen {
                a_x: W::Exact::all(way, a_x),
                a_y: W::Exact::all(way, a_y),
                b_x: W::Exact::all(way, b_x),
                b_y: W::Exact::all(way, b_y),
                left: W::Exact::every(way, a_x * b_y - a_y * b_x > 0.0),
                index: W::Exact::all(way, block.index[k]),
            };
            let bound = W::Exact::all(way, f64::from(bounds[k]));
            let (first, again) = self.ranges(spans.get(k));
            for groups in [first, again] {
                for place in groups {
                    let group = &mut self.groups[place];
                    if group.sees(bound) && group.meet(&seen) {
                        self.meet_exactly(view, block.index[k], place..place + 1);
                    }
                }
            }
        }
    }

    /// Puts a wall to every beam of some groups by [`crate::Wall::cast`], for the
    /// cases that are rare.
    #[cold]
    #[inline(never)]
    fn meet_exactly(&mut self, view: &View<'_>, index: f64, groups: Range<usize>) {
        // Indices come from `u32`; see `Block`.
        let wall = &view.world.walls()[index as usize];
        for group in &mut self.groups[groups] {
            for lane in 0..BEAMS {
                let direction = Vector2::from(group.direction(lane));
                if let Some(t) = wall.cast(&view.origin, &direction) {
                    group.offer(lane, t, index);
                }
            }
        }
    }

    /// Ray by ray, where the bounds of [`sector`] do not hold.
    #[cold]
    fn take_by_rays(&mut self, view: &View<'_>) {
        for group in &mut self.groups {
            group.aim::<<Plain as Way>::Exact>(Plain, view.sin, view.cos, view.max_m);
            for lane in 0..BEAMS {
                let direction = Vector2::from(group.direction(lane));
                let hit = view.world.first_wall(view.origin, direction, view.max_m);
                if let Some((t, index)) = hit {
                    group.offer(lane, t, index as f64);
                }
            }
        }
    }

    /// What each beam met, beam 0 first: distance (`max_m` where nothing) in
    /// metres and the wall's index.
    #[inline]
    pub fn distances_and_walls(&self) -> impl Iterator<Item = (f64, Option<usize>)> {
        let lanes = self.groups.iter().flat_map(|group| group.t.iter().zip(&group.index));
        lanes
            .take(self.fan.beams as usize)
            .map(|(t, index)| (*t, index.is_finite().then_some(*index as usize)))
    }

    /// The unit vector of beam `k` in the world frame, in the scan last taken.
    ///
    /// # Panics
    /// If there are fewer beams.
    #[must_use]
    pub fn direction(&self, k: usize) -> Vector2<f64> {
        Vector2::from(self.groups[k / BEAMS].direction(k % BEAMS))
    }

    /// The distance of each beam into a slice, beam 0 first, m; `max_m` where
    /// nothing is met. Of a slice that is not as long as there are beams, the
    /// part that both have is written.
    pub fn write_distances_m(&self, distances_m: &mut [f64]) {
        let beams = distances_m.len().min(self.fan.beams as usize);
        let (whole, rest) = distances_m[..beams].as_chunks_mut();
        for (four, group) in whole.iter_mut().zip(&self.groups) {
            *four = group.t;
        }
        if let Some(group) = self.groups.get(whole.len()) {
            rest.copy_from_slice(&group.t[..rest.len()]);
        }
    }

    /// What each beam met in `world`, which must be the world it was taken in.
    pub fn hits<'a>(&'a self, world: &'a World) -> impl Iterator<Item = Hit> + 'a {
        self.distances_and_walls().map(|(distance_m, wall)| Hit {
            distance_m,
            material: wall.map(|index| world.walls()[index].material),
        })
    }
}

/// From where a scan looks at what.
struct View<'a> {
    world: &'a World,
    origin: Point2<f64>,
    sin: f64,
    cos: f64,
    bearings: Bearings,
    max_m: f64,
    /// No less than `max_m`.
    max_rough_m: f32,
}

impl View<'_> {
    /// Whether coordinates are such that their products neither overflow nor
    /// vanish, here and in the walls, which are checked.
    fn is_tame(&self) -> bool {
        let tame = |x: f64| x.abs() <= 1e7;
        tame(self.origin.x) && tame(self.origin.y) && self.bearings.base_rad.is_finite()
    }
}
