//! A curve over a map for a robot with a least turning radius that may reverse.
//!
//! Source: D. Dolgov, S. Thrun, M. Montemerlo, J. Diebel, *Path planning for
//! autonomous vehicles in unknown semi-structured environments* (International
//! Journal of Robotics Research 29(5), 2010), §3: A* over cells of position and
//! heading, where every cell keeps the exact pose that it was first left from; states
//! are connected by short arcs, and to the goal by a Reeds-Shepp curve.
//!
//! The body is a disc, so that clearance alone says whether a pose is free.
//!
//! The heuristic is the greater of two costs; both count the factor for reverse if
//! this is less than 1:
//! * the cheapest way over the cells of the map from the goal ([`Routes`]), times
//!   cos(π/8), because a way over eight neighbours is at most 1/cos(π/8) times as long
//!   as a straight line. It knows the walls but not the turning radius. It is not
//!   strictly admissible: a way leads from centre to centre, so that it may cost a cell
//!   more than the curve.
//! * the length of the Reeds-Shepp curve to a goal with a heading. It knows the
//!   turning radius but not the walls. It is admissible: a metre costs at least 1.
//!
//! Departures, and why:
//! * A free curve to the goal does not end the search at once. The search ends when
//!   the curve costs at most `SLACK` times what any open state promises: the first
//!   curve found may turn where there is little room.
//! * A metre costs more near walls by [`super::Room::cost`], not by a Voronoi field: all
//!   ways of this crate have this cost.
//! * Stretches are replaced by Reeds-Shepp curves that cost no more, not smoothed by
//!   conjugate gradients: the curvature is never greater than the robot can drive.
//! * A robot that is too near to a wall may leave it: see `Search::drive`.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};
use std::f64::consts::TAU;

use nalgebra::Point2;
use rusty_geometry::{SE2, trig};

use super::chart::LED_OFF_M;
use super::curve::{Curve, Piece};
use super::reeds_shepp::{Word, reeds_shepp_m, words};
use super::routes::nearest_free;
use super::{Chart, Routes};

/// A cell of the search is this many cells of the map wide.
const WIDTH: i64 = 2;

/// Headings of the search: 5° each.
const HEADINGS: f64 = 72.0;

/// Length of an arc, in cells of the map: more than the diagonal of a cell of the
/// search.
const ARC: f64 = 3.0;

/// Distance of the poses that are checked, in cells of the map.
const SAMPLE: f64 = 0.5;

/// A curve may cost this many times what an open state promises.
const SLACK: f64 = 1.05;

/// Two costs this near are the same.
const EQUAL: f64 = 1.0 + 1e-6;

/// Headings that are tried at a goal without one.
const TRIED: u32 = 16;

/// A curve to the goal is tried from every state where the rest costs less than
/// this, m, from every second state where it costs less than twice this, and so on.
const TRY_M: f64 = 0.5;

/// The search ends after this many states.
const MOST_STATES: usize = 50_000;

/// A shortcut replaces at most this many arcs.
const SHORTCUT: usize = 40;

/// The abilities of a robot and its preferences.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kinematics {
    /// Least turning radius, m, > 0.
    pub radius_m: f64,
    /// Cost of a metre in reverse, in metres forwards, > 0.
    pub reverse: f64,
    /// Cost of a change between forwards and reverse, m, ≥ 0.
    pub switch_m: f64,
}

impl Kinematics {
    /// Returns the cost of a metre of a piece and of the change of direction before
    /// it. `before` is the sign of the length that was driven last.
    fn rates(&self, piece: &Piece, before: f64) -> (f64, f64) {
        let per_metre = if piece.length_m < 0.0 { self.reverse } else { 1.0 };
        let switch_m = if piece.length_m * before < 0.0 { self.switch_m } else { 0.0 };
        (per_metre, switch_m)
    }

    /// Returns the cost of a word where there are no walls, m.
    fn cost(&self, word: &Word, mut before: f64) -> f64 {
        let mut sum_m = 0.0;
        for piece in word.iter().filter(|piece| piece.length_m != 0.0) {
            let (per_metre, switch_m) = self.rates(piece, before);
            sum_m += per_metre * piece.length_m.abs() + switch_m;
            before = piece.length_m;
        }
        sum_m
    }
}

/// A place to go to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    /// Point, world frame, m.
    pub point: Point2<f64>,
    /// Heading, world frame, rad; any if `None`.
    pub heading_rad: Option<f64>,
}

/// Returns a cheap curve to the goal; `None` where none is found. A goal too near to
/// a wall is moved to the nearest cell with room, at most a cell of the map away.
pub fn hybrid_a_star(
    chart: &Chart,
    from: &SE2,
    goal: &Goal,
    kinematics: &Kinematics,
) -> Option<Curve> {
    let search = Search::new(chart, from, goal, kinematics)?;
    Some(search.shorten(&search.run()?))
}

/// A pose and the way that it was reached by.
#[derive(Clone, Copy, Debug)]
struct State {
    pose: SE2,
    /// Cost of the way, m.
    cost: f64,
    /// Length of the last piece, m; its sign is the direction.
    last_m: f64,
    /// Whether the way has had the room that it needs.
    is_free: bool,
}

/// A state of the search and the piece that it was reached by.
struct Node {
    state: State,
    before: usize,
    piece: Piece,
    /// Whether its place in the queue takes the turning radius into account.
    is_exact: bool,
}

struct Search<'a> {
    chart: &'a Chart,
    kinematics: &'a Kinematics,
    start: State,
    /// Clearance at the start, m.
    start_m: f64,
    goal: Goal,
    /// Cheapest ways over the map from the goal.
    routes: Routes,
}

impl<'a> Search<'a> {
    fn new(chart: &'a Chart, from: &SE2, goal: &Goal, kinematics: &'a Kinematics) -> Option<Self> {
        let (clearance, room) = (&chart.clearance, &chart.room);
        let heading_is_finite = goal.heading_rad.is_none_or(f64::is_finite);
        if !(from.is_finite() && heading_is_finite && kinematics.radius_m > 0.0) {
            return None;
        }
        let here = Point2::from(from.translation());
        nearest_free(clearance, room, here, LED_OFF_M)?;
        let cell = nearest_free(clearance, room, goal.point, clearance.frame.cell_m)?;
        let is_free = |point| clearance.at_point(point) >= room.needed_m;
        let point = if is_free(goal.point) { goal.point } else { clearance.frame.centre(cell) };
        Some(Self {
            chart,
            kinematics,
            start: State { pose: *from, cost: 0.0, last_m: 0.0, is_free: is_free(here) },
            start_m: clearance.at_point(here),
            goal: Goal { point, ..*goal },
            routes: Routes::new(clearance, room, cell),
        })
    }

    /// Returns the piece's motions to the poses that are checked.
    fn motions(&self, piece: &Piece) -> Vec<SE2> {
        piece.motions(SAMPLE * self.chart.clearance.frame.cell_m).collect()
    }

    /// Drives a piece, given its motions; `None` where there is not enough room. A
    /// robot that starts too near to a wall may come no nearer and has to have room
    /// half a metre away; without room a metre costs as much as where it just passes.
    fn drive(&self, state: &State, piece: &Piece, motions: &[SE2]) -> Option<State> {
        let room = &self.chart.room;
        let (mut is_free, mut sum) = (state.is_free, 0.0);
        let mut pose = state.pose;
        for next in state.pose.compose_each(motions) {
            pose = next;
            let clearance_m = self.chart.clearance.at_point(Point2::from(pose.translation()));
            is_free |= clearance_m >= room.needed_m;
            let off = pose.translation() - self.start.pose.translation();
            let is_leaving = !is_free && clearance_m >= self.start_m && off.norm() < LED_OFF_M;
            if clearance_m < room.needed_m && !is_leaving {
                return None;
            }
            sum += room.cost(clearance_m.max(room.needed_m));
        }
        let (per_metre, switch_m) = self.kinematics.rates(piece, state.last_m);
        let mean = sum / motions.len() as f64;
        let cost = state.cost + per_metre * piece.length_m.abs() * mean + switch_m;
        Some(State { pose, cost, last_m: piece.length_m, is_free })
    }

    /// Drives a word; `None` where there is not enough room.
    fn drive_word(&self, state: &State, word: &Word) -> Option<State> {
        let mut pieces = word.iter().filter(|piece| piece.length_m != 0.0);
        pieces.try_fold(*state, |state, piece| self.drive(&state, piece, &self.motions(piece)))
    }

    /// Returns the word to one of these poses that is the cheapest without walls.
    fn cheapest(&self, state: &State, to: impl Iterator<Item = SE2>) -> Option<Word> {
        let all = to.flat_map(|to| words(&state.pose, &to, self.kinematics.radius_m));
        let priced = all.map(|word| (self.kinematics.cost(&word, state.last_m), word));
        priced.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, word)| word)
    }

    /// Tries to drive to the goal at once.
    fn finish(&self, state: &State) -> Option<(State, Word)> {
        let (point, here) = (self.goal.point, state.pose.translation());
        let at = |heading_rad: f64| SE2::new(point.x, point.y, heading_rad);
        let word = if let Some(heading_rad) = self.goal.heading_rad {
            self.cheapest(state, std::iter::once(at(heading_rad)))
        } else {
            let ahead_rad = trig::atan2(point.y - here.y, point.x - here.x);
            let around = (0..TRIED).map(|k| ahead_rad + f64::from(k) * TAU / f64::from(TRIED));
            self.cheapest(state, around.chain([state.pose.theta()]).map(at))
        }?;
        Some((self.drive_word(state, &word)?, word))
    }

    /// Returns the cost of the rest without a turning radius; infinite where there is
    /// no way.
    fn rest_on_map(&self, state: &State) -> f64 {
        let point = Point2::from(state.pose.translation());
        let over_cells = self.chart.clearance.frame.cell_at(point).map(|c| self.routes.cost(c));
        let cos_of_eighth = 0.923_879_532_511_286_7;
        let rest_m = match over_cells {
            Some(cost) if state.is_free || cost.is_finite() => cos_of_eighth * cost,
            _ => (self.goal.point - point).norm(),
        };
        self.kinematics.reverse.min(1.0) * rest_m
    }

    /// Returns the cost of the rest without walls; 0 for a goal without a heading.
    fn rest_by_turning(&self, state: &State) -> f64 {
        let Some(heading_rad) = self.goal.heading_rad else { return 0.0 };
        let goal = SE2::new(self.goal.point.x, self.goal.point.y, heading_rad);
        let length_m = reeds_shepp_m(&state.pose, &goal, self.kinematics.radius_m);
        self.kinematics.reverse.min(1.0) * length_m
    }

    /// Cell and heading of a state.
    fn key(&self, state: &State) -> (i64, i64, i64) {
        let point = Point2::from(state.pose.translation());
        let (column, row) = self.chart.clearance.frame.column_row(point);
        let heading = (state.pose.theta() / TAU * HEADINGS).floor();
        (column.div_euclid(WIDTH), row.div_euclid(WIDTH), heading as i64)
    }

    /// Returns the states of a way to the goal, each with the piece to it.
    fn run(&self) -> Option<Vec<(State, Piece)>> {
        let arcs = self.arcs();
        let start = Node { state: self.start, before: 0, piece: Piece::default(), is_exact: false };
        let mut nodes = vec![start];
        let mut best = BTreeMap::from([(self.key(&self.start), 0.0)]);
        let mut open = BinaryHeap::from([Reverse((0_u64, 0))]);
        let (mut states, mut found) = (0, None::<(State, usize, Word)>);
        while let Some(Reverse((bits, index))) = open.pop() {
            let state = nodes[index].state;
            let least = f64::from_bits(bits);
            let is_good = |cost: f64| cost <= SLACK * least;
            if states == MOST_STATES || found.is_some_and(|(end, ..)| is_good(end.cost)) {
                break;
            }
            if best[&self.key(&state)] < state.cost {
                continue;
            }
            let rest = self.rest_on_map(&state);
            if !std::mem::replace(&mut nodes[index].is_exact, true) {
                // Costs are not negative, so their bits are in their order.
                let promised = state.cost + rest.max(self.rest_by_turning(&state));
                if promised > least {
                    open.push(Reverse((promised.to_bits(), index)));
                    continue;
                }
            }
            if states % ((rest / TRY_M) as usize).saturating_add(1) == 0
                && let Some((end, word)) = self.finish(&state)
                && found.is_none_or(|(other, ..)| end.cost < other.cost)
            {
                found = Some((end, index, word));
            }
            states += 1;
            for (piece, motions) in &arcs {
                let Some(next) = self.drive(&state, piece, motions) else { continue };
                let promised = next.cost + self.rest_on_map(&next);
                let known = best.entry(self.key(&next)).or_insert(f64::INFINITY);
                if next.cost * EQUAL < *known && promised.is_finite() {
                    *known = next.cost;
                    open.push(Reverse((promised.to_bits(), nodes.len())));
                    nodes.push(Node { state: next, before: index, piece: *piece, is_exact: false });
                }
            }
        }
        found.map(|(_, index, word)| self.way(&nodes, index, &word))
    }

    /// Returns the arcs between states: three curvatures forwards and in reverse.
    fn arcs(&self) -> Vec<(Piece, Vec<SE2>)> {
        let arc_m = ARC * self.chart.clearance.frame.cell_m;
        let turns = [0.0, 1.0, -1.0].map(|turn| turn / self.kinematics.radius_m);
        let lengths_m = [arc_m, -arc_m].into_iter();
        let pieces = lengths_m
            .flat_map(|length_m| turns.map(|curvature_per_m| Piece { curvature_per_m, length_m }));
        pieces.map(|piece| (piece, self.motions(&piece))).collect()
    }

    /// Returns the states from the start over a node and along a word.
    fn way(&self, nodes: &[Node], last: usize, word: &Word) -> Vec<(State, Piece)> {
        let mut way = vec![(nodes[last].state, nodes[last].piece)];
        let mut at = last;
        while at != 0 {
            at = nodes[at].before;
            way.push((nodes[at].state, nodes[at].piece));
        }
        way.reverse();
        for piece in word.iter().filter(|piece| piece.length_m != 0.0) {
            let next = self.drive(&way[way.len() - 1].0, piece, &self.motions(piece));
            way.extend(next.map(|state| (state, *piece)));
        }
        way
    }

    /// Replaces stretches of a way by words that are not dearer.
    fn shorten(&self, way: &[(State, Piece)]) -> Curve {
        let (mut state, mut at, mut pieces) = (self.start, 0, Vec::new());
        while at + 1 < way.len() {
            let shortcut = |to: usize| {
                let (end, most) = (way[to].0, (way[to].0.cost - way[at].0.cost) * EQUAL);
                let word = self.cheapest(&state, std::iter::once(end.pose))?;
                if self.kinematics.cost(&word, state.last_m) > most {
                    return None;
                }
                let driven = self.drive_word(&state, &word)?;
                // What follows must not need another change of direction.
                let is_same = driven.last_m * end.last_m > 0.0;
                (is_same && driven.cost - state.cost <= most).then_some((to, driven, word))
            };
            let farthest = (at + SHORTCUT).min(way.len() - 1);
            if let Some((to, driven, word)) = (at + 2..=farthest).rev().find_map(shortcut) {
                pieces.extend(word);
                (state, at) = (driven, to);
            } else {
                at += 1;
                pieces.push(way[at].1);
                state = way[at].0;
            }
        }
        Curve::new(self.start.pose, pieces)
    }
}

#[cfg(test)]
#[path = "hybrid_a_star_tests.rs"]
mod tests;
