//! Curves over maps with walls, compared with what is known of them.

use super::*;
use crate::planning::{Room, Unknown};
use crate::{Cell, GridFrame, OccupancyMap, Random};
use rusty_geometry::apartment;
use std::f64::consts::{FRAC_PI_2, PI};

const ROOM: Room = Room { needed_m: 0.22, liked_m: 0.5, dislike: 4.0 };
const CAR: Kinematics = Kinematics { radius_m: 0.4, reverse: 2.0, switch_m: 0.3 };

fn chart(map: &OccupancyMap) -> Chart {
    Chart::new(map, Unknown::Wall, ROOM)
}

/// A map of free cells of 0.05 m in a wall, from 0 to these coordinates.
fn hall(width_m: f64, height_m: f64) -> OccupancyMap {
    let frame = GridFrame::covering([0.0, 0.0, width_m, height_m], 0.05, 0.05);
    let mut map = OccupancyMap { frame, cells: vec![Cell::Free; frame.cells()] };
    block(&mut map, [-1.0, -1.0, width_m + 1.0, 0.0]);
    block(&mut map, [-1.0, height_m, width_m + 1.0, height_m + 1.0]);
    block(&mut map, [-1.0, -1.0, 0.0, height_m + 1.0]);
    block(&mut map, [width_m, -1.0, width_m + 1.0, height_m + 1.0]);
    map
}

/// Occupies the cells whose centres are in a box (x and y from, x and y to, m).
fn block(map: &mut OccupancyMap, [x0, y0, x1, y1]: [f64; 4]) {
    for cell in 0..map.frame.cells() {
        let centre = map.frame.centre(cell);
        if (x0..x1).contains(&centre.x) && (y0..y1).contains(&centre.y) {
            map.cells[cell] = Cell::Occupied;
        }
    }
}

fn to(x: f64, y: f64, heading_rad: Option<f64>) -> Goal {
    Goal { point: Point2::new(x, y), heading_rad }
}

/// Checks that a curve leads to the goal, has room and is not curved too much.
fn check(chart: &Chart, curve: &Curve, goal: &Goal) {
    let end = curve.end();
    assert!((Point2::from(end.translation()) - goal.point).norm() < 1e-9, "{end:?}");
    if let Some(heading_rad) = goal.heading_rad {
        let turn_rad = rusty_geometry::wrap_angle(end.theta() - heading_rad);
        assert!(turn_rad.abs() < 1e-9, "{end:?}");
    }
    let most_per_m = 1.0 / CAR.radius_m;
    assert!(curve.pieces.iter().all(|piece| piece.curvature_per_m.abs() <= most_per_m));
    for pose in curve.samples(0.005) {
        let clearance_m = chart.clearance.at_point(Point2::from(pose.translation()));
        // Between two samples it may touch the corner of a cell.
        assert!(clearance_m > ROOM.needed_m - 0.03, "{clearance_m} m at {pose:?}");
    }
}

/// Returns the states at the ends of the pieces of a curve, as the search has them.
fn states(search: &Search, curve: &Curve) -> Vec<State> {
    let mut states = vec![search.start];
    for piece in &curve.pieces {
        let next = search.drive(&states[states.len() - 1], piece, &search.motions(piece));
        states.push(next.unwrap());
    }
    states
}

fn is_reverse(piece: &Piece) -> bool {
    piece.length_m < 0.0
}

const ROOMS: [(f64, f64); 6] =
    [(1.8, 7.0), (5.4, 7.0), (1.3, 2.5), (4.9, 2.5), (9.6, 3.0), (10.0, 7.5)];

#[test]
fn every_room_of_the_apartment_is_reached_for_no_less_than_the_heuristic() {
    let chart = chart(&OccupancyMap::of_world(&apartment(), 0.1, 0.05));
    for quarter in 0..4 {
        let from = SE2::new(6.0, 4.5, FRAC_PI_2 * f64::from(quarter));
        for (x, y) in ROOMS {
            for heading_rad in [None, Some(FRAC_PI_2 * f64::from(quarter) + 0.3)] {
                let goal = to(x, y, heading_rad);
                let curve = hybrid_a_star(&chart, &from, &goal, &CAR).unwrap();
                check(&chart, &curve, &goal);
                let search = Search::new(&chart, &from, &goal, &CAR).unwrap();
                let states = states(&search, &curve);
                let end = states[states.len() - 1];
                assert!(end.cost < 2.2 * search.rest_on_map(&search.start), "{}", end.cost);
                for state in &states {
                    let rest = end.cost - state.cost;
                    assert!(rest > search.rest_by_turning(state) - 1e-9);
                    // A way over cells may cost a cell more than the curve.
                    assert!(rest > search.rest_on_map(state) - 0.1);
                }
            }
        }
    }
}

#[test]
fn the_same_search_gives_the_same_curve() {
    let chart = chart(&OccupancyMap::of_world(&apartment(), 0.1, 0.05));
    let (from, goal) = (SE2::new(6.0, 4.5, 0.0), to(1.8, 7.0, Some(1.0)));
    let curve = hybrid_a_star(&chart, &from, &goal, &CAR);
    assert_eq!(curve, hybrid_a_star(&chart, &from, &goal, &CAR));
}

#[test]
fn in_a_narrow_corridor_it_reverses_or_turns_in_moves() {
    let chart = chart(&hall(6.0, 1.0));
    let from = SE2::new(4.0, 0.5, 0.0);
    // The circle of 0.8 m does not fit in the 0.6 m that the centre may use. Near the
    // goal it reverses all the way; where this is dear, it turns first.
    let goals = [to(1.0, 0.5, Some(0.0)), to(3.2, 0.5, None), to(1.0, 0.5, None)];
    let straight_back = [true, true, false];
    for (goal, straight_back) in goals.into_iter().zip(straight_back) {
        let curve = hybrid_a_star(&chart, &from, &goal, &CAR).unwrap();
        check(&chart, &curve, &goal);
        if straight_back {
            assert!(curve.pieces.iter().all(is_reverse), "{curve:?}");
            assert!((curve.length_m() - 4.0 + goal.point.x).abs() < 0.03, "{curve:?}");
        } else {
            assert!(curve.switches() >= 2 && curve.length_m() < 5.0, "{curve:?}");
            assert!(!curve.pieces.last().is_some_and(is_reverse), "{curve:?}");
        }
    }
    let goal = to(1.0, 0.5, Some(PI));
    let curve = hybrid_a_star(&chart, &from, &goal, &CAR).unwrap();
    check(&chart, &curve, &goal);
    assert!(curve.switches() >= 2 && curve.length_m() < 5.0, "{curve:?}");
}

#[test]
fn it_parks_between_two_boxes() {
    let mut map = hall(6.0, 2.5);
    block(&mut map, [1.0, 0.0, 2.2, 0.7]);
    block(&mut map, [3.1, 0.0, 4.5, 0.7]);
    let chart = chart(&map);
    for from in [SE2::new(1.0, 1.5, 0.0), SE2::new(5.0, 1.2, PI)] {
        for heading_rad in [0.0, FRAC_PI_2, PI, -FRAC_PI_2] {
            let goal = to(2.65, 0.35, Some(heading_rad));
            let curve = hybrid_a_star(&chart, &from, &goal, &CAR).unwrap();
            check(&chart, &curve, &goal);
            // It reverses into the place if it has to look out of it.
            if heading_rad == FRAC_PI_2 {
                assert!(curve.pieces.last().is_some_and(is_reverse), "{curve:?}");
            }
        }
    }
}

#[test]
fn without_a_way_there_is_no_curve() {
    let mut map = hall(6.0, 3.0);
    block(&mut map, [3.0, 0.0, 3.1, 3.0]);
    let divided = chart(&map);
    let from = SE2::new(1.0, 1.0, 0.0);
    let found = |chart: &Chart, from: &SE2, goal: Goal| hybrid_a_star(chart, from, &goal, &CAR);
    assert_eq!(found(&divided, &from, to(5.0, 1.0, None)), None);
    // In a wall, off the map, or nowhere.
    assert_eq!(found(&divided, &from, to(3.05, 1.0, None)), None);
    assert_eq!(found(&divided, &from, to(9.0, 1.0, None)), None);
    assert_eq!(found(&divided, &from, to(f64::NAN, 1.0, None)), None);
    assert_eq!(found(&divided, &from, to(2.0, 1.0, Some(f64::NAN))), None);
    assert_eq!(found(&divided, &SE2::new(9.0, 1.0, 0.0), to(2.0, 1.0, None)), None);
    // A half turn with a radius of 20 m in a corridor.
    let wide = Kinematics { radius_m: 20.0, ..CAR };
    let (corridor, from) = (chart(&hall(6.0, 1.0)), SE2::new(4.0, 0.5, 0.0));
    assert_eq!(hybrid_a_star(&corridor, &from, &to(1.0, 0.5, Some(PI)), &wide), None);
}

#[test]
fn without_walls_it_is_the_shortest_curve() {
    let frame = GridFrame::covering([-5.0, -5.0, 5.0, 5.0], 0.0, 0.05);
    let chart = chart(&OccupancyMap { frame, cells: vec![Cell::Free; frame.cells()] });
    let plain = Kinematics { radius_m: 0.5, reverse: 1.0, switch_m: 0.0 };
    let mut random = Random::new(1, 7);
    for _ in 0..50 {
        let mut draw = |size: f64| size * (2.0 * random.uniform() - 1.0);
        let (from, at) = (SE2::new(draw(3.0), draw(3.0), draw(PI)), [draw(3.0), draw(3.0)]);
        let heading_rad = draw(PI);
        let shortest_m = reeds_shepp_m(&from, &SE2::new(at[0], at[1], heading_rad), 0.5);
        let goal = to(at[0], at[1], Some(heading_rad));
        let curve = hybrid_a_star(&chart, &from, &goal, &plain).unwrap();
        assert!((curve.length_m() - shortest_m).abs() < 1e-9, "{} {shortest_m}", curve.length_m());
        let free = hybrid_a_star(&chart, &from, &to(at[0], at[1], None), &plain).unwrap();
        assert!(free.length_m() < 1.03 * shortest_m + 0.02, "{} {shortest_m}", free.length_m());
    }
    let here = hybrid_a_star(&chart, &SE2::new(1.0, 1.0, 2.0), &to(1.0, 1.0, None), &plain);
    assert!(here.unwrap().pieces.is_empty());
}

#[test]
fn a_robot_too_near_to_a_wall_leaves_it() {
    let chart = chart(&hall(6.0, 3.0));
    for eighth in 0..8 {
        let from = SE2::new(2.0, 0.13, FRAC_PI_2 * 0.5 * f64::from(eighth));
        let goal = to(4.0, 2.0, None);
        let curve = hybrid_a_star(&chart, &from, &goal, &CAR).unwrap();
        let mut is_free = false;
        for pose in curve.samples(0.005) {
            let clearance_m = chart.clearance.at_point(Point2::from(pose.translation()));
            is_free |= clearance_m >= ROOM.needed_m;
            assert!(clearance_m > if is_free { ROOM.needed_m - 0.03 } else { 0.12 }, "{pose:?}");
        }
        assert!(is_free);
    }
}
