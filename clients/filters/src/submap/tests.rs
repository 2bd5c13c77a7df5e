//! The search finds what trying every pose finds, and says how sure it is.

use std::f64::consts::PI;

use rusty_contract::config::LidarConfig;
use rusty_geometry::{Scan, World, apartment};

use super::*;
use crate::icp::Laser;
use crate::scan_match::tests::{corridor, world_of};

/// The laser of these scans; its range is of no account.
fn laser() -> Laser {
    Laser::new(&LidarConfig::default())
}

/// A scan without noise.
fn rays(world: &World, pose: &SE2) -> Vec<Ray> {
    rays_within(world, pose, LidarConfig::default().range_max_m)
}

/// A scan without noise by a laser with this range.
fn rays_within(world: &World, pose: &SE2, range_max_m: f64) -> Vec<Ray> {
    rays_of(world, pose, &LidarConfig { range_max_m, ..LidarConfig::default() })
}

/// A scan without noise by this laser.
fn rays_of(world: &World, pose: &SE2, lidar: &LidarConfig) -> Vec<Ray> {
    let mut scan = Scan::new(lidar.fan());
    scan.take(world, pose, lidar.range_max_m);
    let ranges: Vec<f64> = scan.distances_and_walls().map(|(range_m, _)| range_m).collect();
    Laser::new(lidar).rays(&ranges)
}

fn score_of(map: &Submap, rays: &[Ray], window: &Window, turn: i32, offset: [i32; 2]) -> f64 {
    let cells = cells(&thinned(rays), &window.at(turn, [0; 2]));
    map.mean(&cells, offset) - window.cost(0, turn, offset)
}

#[test]
fn branch_and_bound_finds_the_best_of_all_poses() {
    let world = apartment();
    let (there, moved) = (SE2::new(8.0, 2.0, 1.0), SE2::new(0.31, -0.22, 0.21));
    let (old, new) = (rays(&world, &there), rays(&world, &(there * moved)));
    for unseen in [Unseen::Misses, Unseen::LeftOut] {
        let map = Submap::new(&laser(), [(SE2::identity(), old.as_slice())].into_iter(), unseen);
        let window = Window::new(SE2::new(0.02, 0.01, 0.03), 0.4, 0.25);
        let found = map.search(&new, &window)[0].unwrap();
        assert!(found.pose.boxminus(&moved).norm() < 0.08, "{found:?}");
        let mut best = f64::NEG_INFINITY;
        for turn in -20..=20 {
            for y in -8..=8 {
                for x in -8..=8 {
                    best = best.max(score_of(&map, &new, &window, turn, [x, y]));
                }
            }
        }
        let apart = found.pose.translation() - window.centre.translation();
        let offset = [apart.x, apart.y].map(|m| (m / CELL_M).round() as i32);
        let turn = ((found.pose.theta() - window.centre.theta()) / TURN_RAD).round() as i32;
        assert_eq!(score_of(&map, &new, &window, turn, offset), best);
        // A scan of another room scores less.
        let other = rays(&world, &SE2::new(2.0, 6.0, 0.4));
        let other = map.search(&other, &window)[0].unwrap();
        assert!(other.score < 0.7 * found.score, "{other:?}, {found:?}");
    }
}

#[test]
fn walls_that_no_scan_looked_at_hold_no_pose_back() {
    // A metre down a corridor of 3 m by a laser that sees 4 m.
    let walls = [[-30.0, -1.5, 30.0, -1.5], [-30.0, 1.5, 30.0, 1.5]];
    let wide = world_of([-30.0, -2.0, 30.0, 2.0], &walls);
    let scan = |x: f64| rays_within(&wide, &SE2::new(x, 0.0, 0.0), 4.0);
    let (old, new) = (scan(0.0), scan(1.0));
    let loss = |unseen: Unseen| {
        let map = Submap::new(&laser(), [(SE2::identity(), old.as_slice())].into_iter(), unseen);
        let [stays, moves] = [0.0, 1.0].map(|x| map.score(&new, &SE2::new(x, 0.0, 0.0)));
        stays - moves
    };
    let [misses, left_out] = [Unseen::Misses, Unseen::LeftOut].map(loss);
    assert!(misses > 0.08 && left_out < 0.05, "{misses} {left_out}");
    // An end behind a wall is not new, and ends that are all new fit nothing well.
    let map =
        Submap::new(&laser(), [(SE2::identity(), old.as_slice())].into_iter(), Unseen::LeftOut);
    let behind = map.score(&new, &SE2::new(1.0, 0.4, 0.0));
    let beyond = map.score(&new, &SE2::new(11.0, 0.0, 0.0));
    assert!(behind < 0.5 && beyond < 0.3, "{behind} {beyond}");
}

#[test]
fn a_corridor_leaves_the_guess_along_it() {
    let there = SE2::new(-3.0, 0.1, 0.0);
    let rays = rays(&corridor(), &there);
    let map =
        Submap::new(&laser(), [(SE2::identity(), rays.as_slice())].into_iter(), Unseen::Misses);
    let window = Window::new(SE2::new(0.0, 0.15, 0.1), 0.5, 0.5);
    let found = map.search(&rays, &window)[0].unwrap().pose;
    assert!(found.x().abs() < 0.21 && found.y().abs() < 0.06, "{found:?}");
    assert!(found.theta().abs() < 0.02, "{found:?}");
    let spread = map.spread(&rays, &SE2::identity()).unwrap().covariance;
    // Too sure along the corridor: far ends are too sparse to be drawn as a wall.
    assert!(spread[(0, 0)] > 1.5 * spread[(1, 1)], "{spread}");
}

#[test]
fn a_pose_on_a_slope_has_no_spread() {
    let rays = rays(&apartment(), &SE2::new(8.0, 2.0, 1.0));
    let map =
        Submap::new(&laser(), [(SE2::identity(), rays.as_slice())].into_iter(), Unseen::Misses);
    let best = map.spread(&rays, &SE2::identity()).unwrap();
    assert!(best.covariance[(0, 0)].sqrt() < 0.1, "{best:?}");
    for [x, y, theta] in [[0.3, 0.0, 0.0], [0.0, -0.2, 0.0], [0.0, 0.0, 0.1]] {
        assert_eq!(map.spread(&rays, &SE2::new(x, y, theta)), None, "{x} {y} {theta}");
    }
}

#[test]
fn a_scan_of_few_ends_is_meagre() {
    let whole = rays(&apartment(), &SE2::new(8.0, 2.0, 1.0));
    assert!(!is_meagre(&laser(), &whole) && is_meagre(&laser(), &whole[..31]));
}

#[test]
fn nothing_seen_finds_nothing() {
    let window = Window::new(SE2::identity(), 0.5, 0.5);
    let rays = rays(&apartment(), &SE2::new(8.0, 2.0, 1.0));
    for unseen in [Unseen::Misses, Unseen::LeftOut] {
        let map = Submap::new(&laser(), std::iter::empty(), unseen);
        assert_eq!(map.search(&[], &window), [None, None]);
        assert_eq!(map.search(&rays, &window)[0].unwrap().score, 0.0);
    }
}

#[test]
fn a_pose_leads_where_no_other_one_scores_nearly_as_much() {
    let of = |score: f64| Placement { pose: SE2::identity(), score };
    assert!(of(0.5).leads(None, 0.1) && of(0.5).leads(Some(&of(0.375)), 0.125));
    assert!(!of(0.5).leads(Some(&of(0.45)), 0.1) && !of(0.5).leads(Some(&of(0.7)), 0.1));
}

#[test]
fn ends_in_the_air_do_not_make_a_map_where_every_pose_fits() {
    // Eight scans of a room, in each of which a third of the beams end anywhere.
    let world = apartment();
    let here = SE2::new(8.0, 2.0, 1.0);
    let mut random = crate::Random::new(3, 1);
    let mut scan = Scan::new(LidarConfig::default().fan());
    scan.take(&world, &here, LidarConfig::default().range_max_m);
    let mut short = || {
        let ranges = scan.distances_and_walls().map(|(range_m, _)| {
            let is_wrong = random.uniform() < 1.0 / 3.0;
            if is_wrong { range_m * (0.1 + 0.9 * random.uniform()) } else { range_m }
        });
        laser().rays(&ranges.collect::<Vec<_>>())
    };
    let old: Vec<Vec<Ray>> = (0..8).map(|_| short()).collect();
    let scans = old.iter().map(|rays| (SE2::identity(), rays.as_slice()));
    let map = Submap::new(&laser(), scans, Unseen::LeftOut);
    let new = short();
    let right = map.score(&new, &SE2::identity());
    let turned = map.score(&new, &SE2::new(0.0, 0.0, 0.4));
    assert!(right > 0.6 && turned < 0.35, "{right} {turned}");
}

#[test]
fn a_piece_of_a_wall_is_narrow_and_a_corner_is_not() {
    let walls = [[-30.0, 9.0, 8.0, 9.0], [8.0, 9.0, 8.0, -9.0]];
    let world = world_of([-30.0, -9.0, 30.0, 9.0], &walls);
    let is_narrow = |x: f64, y: f64, theta: f64, fov_rad: f64| {
        let first_bearing_rad = -0.5 * fov_rad;
        let lidar =
            LidarConfig { fov_rad, first_bearing_rad, beams: 180, ..LidarConfig::default() };
        let laser = Laser::new(&lidar);
        is_narrow(&laser, &rays_of(&world, &SE2::new(x, y, theta), &lidar))
    };
    // A wall 2 m ahead, a long one, and the corner.
    assert!(is_narrow(6.0, 0.0, 0.0, 1.2));
    assert!(!is_narrow(2.0, 0.0, 0.0, 1.2));
    assert!(!is_narrow(5.0, 6.0, 0.25 * PI, 1.2));
    // The same walls in a wide view.
    assert!(!is_narrow(6.0, 0.0, 0.0, PI));
    // One wall in a view all round: of 180 beams it is all there is, of 60 it may be more.
    let is_one_wall = |beams: u32| {
        let lidar = LidarConfig { beams, range_max_m: 2.2, ..LidarConfig::default() };
        let rays = rays_of(&world, &SE2::new(6.0, 0.0, 0.0), &lidar);
        super::is_narrow(&Laser::new(&lidar), &rays)
    };
    assert!(is_one_wall(180) && !is_one_wall(60));
    let near = LidarConfig { range_max_m: 1.5, ..LidarConfig::default() };
    let rays = rays_of(&world, &SE2::new(7.5, 0.0, 0.0), &near);
    assert!(super::is_narrow(&Laser::new(&near), &rays));
}
