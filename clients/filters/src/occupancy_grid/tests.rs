//! The book's update by hand, and the Apartment from true poses.

use super::*;
use crate::Random;
use rusty_contract::LidarConfig;
use rusty_geometry::{Scan, World, apartment};

fn one_beam(model: InverseModel, scans: &[(SE2, f64)]) -> OccupancyGrid {
    let lidar = LidarConfig { beams: 1, first_bearing_rad: 0.0, ..LidarConfig::default() };
    let beams = Beams::new(&lidar);
    let mut grid = OccupancyGrid::new(model);
    for (pose, range_m) in scans {
        grid.add(pose, &[*range_m], &beams).unwrap();
    }
    grid
}

fn odds_at(grid: &OccupancyGrid, x_m: f64, y_m: f64) -> f64 {
    grid.frame().cell_at(Point2::new(x_m, y_m)).map_or(0.0, |cell| grid.log_odds(cell))
}

const COARSE: InverseModel = InverseModel {
    cell_m: 0.1,
    p_occupied: 0.8,
    p_free: 0.3,
    p_most: 0.999,
    p_least: 0.001,
    thickness_m: 0.0,
    nothing_met: NothingMet::Clears,
    nothing_m: 100.0,
    reach_m: None,
};

#[test]
fn cells_of_a_beam_are_the_book_s_update_by_hand() {
    // From the middle of cell 0 along x: three beams end in cell 5, one in 7.
    let at = SE2::new(0.05, 0.05, 0.0);
    let scans = [(at, 0.5), (at, 0.52), (at, 0.7), (at, 0.48)];
    let grid = one_beam(COARSE, &scans);
    let (occupied, free) = (trig::ln(0.8_f64 / 0.2), trig::ln(0.3_f64 / 0.7));
    let wanted = [
        4.0 * free,
        4.0 * free,
        4.0 * free,
        4.0 * free,
        4.0 * free,
        3.0 * occupied + free,
        free,
        occupied,
        0.0,
    ];
    for (k, wanted) in wanted.into_iter().enumerate() {
        let found = odds_at(&grid, 0.05 + 0.1 * k as f64, 0.05);
        assert!((found - wanted).abs() < 1e-4, "cell {k}: {found} for {wanted}");
        assert_eq!(odds_at(&grid, 0.05 + 0.1 * k as f64, 0.15), 0.0);
    }
    let cell = grid.frame().cell_at(Point2::new(0.55, 0.05)).unwrap();
    // 0.8³ 0.3 to 0.2³ 0.7: Bayes' rule for the four readings at once.
    let (yes, no) = (0.8 * 0.8 * 0.8 * 0.3, 0.2 * 0.2 * 0.2 * 0.7);
    assert!((grid.probability(cell) - yes / (yes + no)).abs() < 1e-4);
}

#[test]
fn things_are_as_thick_as_is_believed() {
    let model = InverseModel { thickness_m: 0.4, ..COARSE };
    let grid = one_beam(model, &[(SE2::new(0.05, 0.05, 0.0), 1.0)]);
    let signs: Vec<f64> =
        (0..15).map(|k| odds_at(&grid, 0.05 + 0.1 * f64::from(k), 0.05).signum()).collect();
    // α/2 before the end and α/2 behind it: cells 8 to 12.
    let wanted = |k| if k < 8 { -1.0 } else { 1.0 };
    assert!((0..=12).all(|k| signs[k] == wanted(k)), "{signs:?}");
    assert_eq!(odds_at(&grid, 1.35, 0.05), 0.0);
}

#[test]
fn a_beam_that_met_nothing_clears_and_occupies_nothing() {
    let at = SE2::new(0.05, 0.05, 0.0);
    let scans = [(at, 1.0), (at, 8.0)];
    let odds = |nothing_met, x_m| {
        let grid = one_beam(InverseModel { nothing_met, ..COARSE }, &scans);
        odds_at(&grid, x_m, 0.05)
    };
    let free = trig::ln(0.3_f64 / 0.7);
    let near = |a: f64, b: f64| (a - b).abs() < 1e-4;
    assert!(near(odds(NothingMet::Clears, 0.55), 2.0 * free));
    assert!(near(odds(NothingMet::Clears, 5.05), free));
    assert!(near(odds(NothingMet::Clears, 8.05), free));
    assert!(near(odds(NothingMet::Stops, 0.55), 2.0 * free));
    assert!(near(odds(NothingMet::Stops, 1.05), trig::ln(0.8_f64 / 0.2)));
    assert!(near(odds(NothingMet::Stops, 5.05), 0.0));
    assert!(near(odds(NothingMet::Ignored, 0.55), free));
    let near_only = InverseModel { nothing_m: 3.0, ..COARSE };
    let grid = one_beam(near_only, &scans);
    assert!(near(odds_at(&grid, 2.95, 0.05), free) && near(odds_at(&grid, 3.25, 0.05), 0.0));
    // Beyond the reach something was met, so there is none of it before.
    let short = InverseModel { reach_m: Some(0.6), ..COARSE };
    let grid = one_beam(short, &scans[..1]);
    assert!(near(odds_at(&grid, 0.55, 0.05), free) && near(odds_at(&grid, 1.05, 0.05), 0.0));
}

#[test]
fn log_odds_stay_within_their_bounds() {
    let at = SE2::new(0.05, 0.05, 0.0);
    let grid = one_beam(COARSE, &[(at, 1.0); 40]);
    assert!((odds_at(&grid, 1.05, 0.05) - trig::ln(0.999_f64 / 0.001)).abs() < 1e-4);
    assert!((odds_at(&grid, 0.55, 0.05) - trig::ln(0.001_f64 / 0.999)).abs() < 1e-4);
}

#[test]
fn what_says_nothing_changes_nothing_and_what_is_too_much_is_named() {
    let lidar = LidarConfig { beams: 4, ..LidarConfig::default() };
    let beams = Beams::new(&lidar);
    let mut grid = OccupancyGrid::new(InverseModel::default());
    for ranges_m in [&[][..], &[f64::NAN, 0.0, -1.0, f64::NAN], &[f64::NAN; 9]] {
        grid.add(&SE2::identity(), ranges_m, &beams).unwrap();
    }
    assert_eq!(grid.known(), None);
    assert_eq!(grid.to_map().cells, [Cell::Unknown]);
    let error = grid.add(&SE2::new(f64::NAN, 0.0, 0.0), &[1.0; 4], &beams).unwrap_err();
    assert!(error.to_string().contains("which is no pose"), "{error}");
    for (far_m, wanted) in [(1e5, "the map would have"), (1e300, "2⁴⁰ cells from the origin")] {
        let error = grid.add(&SE2::new(far_m, 0.0, 0.0), &[1.0; 4], &beams).unwrap_err();
        assert!(error.to_string().contains(wanted), "{error}");
    }
    // An infinite range is one of nothing met.
    grid.add(&SE2::identity(), &[f64::INFINITY; 4], &beams).unwrap();
    assert!(odds_at(&grid, 5.0, 0.0) < 0.0);
}

#[test]
fn a_first_pose_far_off_is_named_and_leaves_the_grid_as_it_was() {
    let beams = Beams::new(&LidarConfig { beams: 4, ..LidarConfig::default() });
    for far_m in [1e11, 1e17, 1e300, -1e17] {
        for pose in [SE2::new(far_m, 0.0, 0.0), SE2::new(0.0, far_m, 0.0)] {
            let mut grid = OccupancyGrid::new(InverseModel::default());
            let error = grid.add(&pose, &[1.0; 4], &beams).unwrap_err();
            assert!(matches!(error, GridError::TooFar { .. }), "{error}");
            grid.add(&SE2::identity(), &[1.0; 4], &beams).unwrap();
            assert!(odds_at(&grid, 1.0, 0.0) > 0.0 && grid.scans() == 1, "{far_m}");
        }
    }
    // So far cells are told apart.
    let mut grid = OccupancyGrid::new(InverseModel::default());
    grid.add(&SE2::new(-5e10, 5e10, 0.0), &[1.0; 4], &beams).unwrap();
    assert!(odds_at(&grid, -5e10 + 1.0, 5e10) > 0.0);
}

#[test]
fn what_could_not_work_is_refused() {
    #[derive(Debug, clap::Parser)]
    struct Cli {
        #[command(flatten)]
        model: InverseModel,
    }
    let given = |option: &str, value: &str| {
        <Cli as clap::Parser>::try_parse_from(["cli", option, value]).map(|cli| cli.model)
    };
    for (option, good, bad) in [
        ("--p-occupied", "0.51", "0.500001"),
        ("--p-free", "0.49", "0.499999"),
        ("--p-most", "0.66", "0.65"),
        ("--p-least", "0.19", "0.196"),
        ("--p-most", "0.999999", "NaN"),
        ("--p-least", "0.000001", "0"),
    ] {
        assert!(given(option, good).is_ok(), "{option} {good}");
        assert!(given(option, bad).is_err(), "{option} {bad}");
    }
    // What is just let in marks cells.
    for option in [["--p-occupied", "0.51"], ["--p-most", "0.66"]] {
        let grid = one_beam(given(option[0], option[1]).unwrap(), &[(SE2::identity(), 1.0); 40]);
        assert!(grid.to_map().cells.contains(&Cell::Occupied), "{option:?}");
    }
    for option in [["--p-free", "0.49"], ["--p-least", "0.19"]] {
        let grid = one_beam(given(option[0], option[1]).unwrap(), &[(SE2::identity(), 1.0); 40]);
        assert!(grid.to_map().cells.contains(&Cell::Free), "{option:?}");
    }
}

/// What a laser with these beams reads in `world` from `poses`: σ 2 cm, and one
/// reading in fifty is none.
fn scans(world: &World, lidar: &LidarConfig, poses: &[SE2]) -> Vec<Vec<f64>> {
    let (mut scan, mut random) = (Scan::new(lidar.fan()), Random::new(1, 1));
    let mut read = |pose: &SE2| {
        scan.take(world, pose, lidar.range_max_m);
        let mut ranges_m = vec![0.0; lidar.beams as usize];
        scan.write_distances_m(&mut ranges_m);
        for range_m in &mut ranges_m {
            let noisy_m = *range_m + 0.02 * random.normal();
            let is_lost = random.uniform() < 0.02 || *range_m >= lidar.range_max_m;
            *range_m = if is_lost { lidar.range_max_m } else { noisy_m };
        }
        ranges_m
    };
    poses.iter().map(&mut read).collect()
}

/// Poses all over the five rooms, not nearer than 0.2 m to a wall.
fn all_over(world: &World) -> Vec<SE2> {
    let [x0, y0, x1, y1] = world.bounds();
    let mut random = Random::new(2, 1);
    let any = std::iter::repeat_with(|| {
        let x = x0 + (x1 - x0) * random.uniform();
        SE2::new(x, y0 + (y1 - y0) * random.uniform(), 6.0 * random.uniform() - 3.0)
    });
    any.filter(|p| world.distance_to_nearest(Point2::from(p.translation())) > 0.2)
        .take(300)
        .collect()
}

fn grid_of(model: InverseModel, lidar: &LidarConfig, seen: &[(SE2, Vec<f64>)]) -> OccupancyGrid {
    let (beams, mut grid) = (Beams::new(lidar), OccupancyGrid::new(model));
    for (pose, ranges_m) in seen {
        grid.add(pose, ranges_m, &beams).unwrap();
    }
    grid
}

/// Whether a cell within `around` cells of this one is occupied.
fn has_neighbour(map: &OccupancyMap, point: Point2<f64>, around: i64) -> bool {
    let (column, row) = map.frame.column_row(point);
    (-around..=around).any(|dx| {
        (-around..=around).any(|dy| {
            let cell = map.frame.index(column + dx, row + dy);
            cell.is_some_and(|cell| map.cells[cell] == Cell::Occupied)
        })
    })
}

#[test]
fn the_apartment_from_true_poses_is_its_walls_within_a_cell() {
    let (world, lidar) = (apartment(), LidarConfig::default());
    let poses = all_over(&world);
    let ranges_m = scans(&world, &lidar, &poses);
    let seen: Vec<(SE2, Vec<f64>)> = poses.into_iter().zip(ranges_m).collect();
    let map = grid_of(InverseModel::default(), &lidar, &seen).to_map();
    let walls = OccupancyMap::of_world(&world, 0.2, 0.05);
    let (mut count, mut beside) = ([0_u32; 3], 0);
    for (cell, found) in map.cells.iter().enumerate() {
        let centre = map.frame.centre(cell);
        count[*found as usize] += 1;
        if *found == Cell::Occupied {
            let distance_m = world.distance_to_nearest(centre);
            // Some part of it is not farther off than a cell.
            assert!(distance_m < 0.05 + 0.5 * 0.0708, "{centre} is {distance_m} m from a wall");
            // A wall on a border belongs to the cell on one side of it, and its
            // echoes to both.
            assert!(has_neighbour(&walls, centre, 2), "{centre}");
            beside += u32::from(has_neighbour(&walls, centre, 1));
        }
    }
    assert!(f64::from(beside) > 0.95 * f64::from(count[1]), "{beside} of {}", count[1]);
    // Nine tenths of 12 m × 9 m and more are free, and nothing beyond is.
    let free_m2 = f64::from(count[0]) * 0.05 * 0.05;
    assert!((97.0..=108.5).contains(&free_m2), "{free_m2} m² free");
    let of_walls = (0..walls.cells.len()).filter(|cell| walls.cells[*cell] == Cell::Occupied);
    let (mut all, mut met) = (0, 0);
    for cell in of_walls {
        all += 1;
        met += u32::from(has_neighbour(&map, walls.frame.centre(cell), 1));
    }
    assert!(f64::from(met) > 0.99 * f64::from(all), "{met} of {all} cells of the walls");
}

#[test]
fn scans_may_come_in_any_order() {
    let (world, lidar) = (apartment(), LidarConfig::default());
    let poses = all_over(&world);
    let ranges_m = scans(&world, &lidar, &poses);
    let mut seen: Vec<(SE2, Vec<f64>)> = poses.into_iter().zip(ranges_m).take(15).collect();
    // Without bounds, and with beams that do not look at the map.
    let model = InverseModel { nothing_met: NothingMet::Clears, ..InverseModel::default() };
    let model = InverseModel { p_most: 0.999_999, p_least: 1e-12, ..model };
    let forwards = grid_of(model, &lidar, &seen);
    seen.reverse();
    let backwards = grid_of(model, &lidar, &seen);
    // Grown in another order, the two may have other margins.
    let (a, b) = (forwards.known().unwrap(), backwards.known().unwrap());
    assert_eq!(a.1, b.1);
    for cell in 0..a.1.cells() {
        let odds =
            |grid: &OccupancyGrid| grid.log_odds[grid.frame.cell_at(a.1.centre(cell)).unwrap()];
        assert_eq!(odds(&forwards), odds(&backwards), "cell {cell}");
        // No bound was met that would have hidden an order.
        assert!(odds(&forwards).abs() < fixed(0.999_999));
    }
}

#[test]
fn a_grid_that_grew_knows_what_it_knew() {
    let at = |x| (SE2::new(x, 0.05, 0.0), 1.0);
    let one = one_beam(COARSE, &[at(0.05), at(90.05), at(-70.03)]);
    for (x_m, _) in [(0.05, 0), (90.05, 0), (-70.03, 0)] {
        assert!(odds_at(&one, x_m + 0.5, 0.05) < 0.0 && odds_at(&one, x_m + 1.0, 0.05) > 0.0);
    }
    assert_eq!(one.log_odds.iter().filter(|odds| **odds > 0).count(), 3);
    assert_eq!(one.frame().width as i64 % GROWTH, 0);
}
