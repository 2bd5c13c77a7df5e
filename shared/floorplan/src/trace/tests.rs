//! Walls of small maps, to the cell; of random ones, within the tolerance.

use rusty_geometry::{Wall, World, trig};

use super::*;

/// A map of cells of 0.5 m from rows of text, the upper first: `#` is occupied.
fn map(rows: &[String]) -> RosMap {
    let cell = |c: char| if c == '#' { Cell::Occupied } else { Cell::Free };
    let cells = rows.iter().rev().flat_map(|row| row.chars().map(cell)).collect();
    let width = rows[0].chars().count();
    RosMap { origin_m: [-1.0, 2.0], yaw_rad: 0.0, cell_m: 0.5, width, cells }
}

fn drawn(rows: &[&str]) -> RosMap {
    map(&rows.iter().map(|row| (*row).to_owned()).collect::<Vec<_>>())
}

/// The cells whose centre is nearer than half a cell (in y) to a line.
fn line(width: usize, rise_per_cell: f64, thick: i32) -> RosMap {
    let height = (width as f64 * rise_per_cell) as i32 + thick + 4;
    let row = |y: i32| {
        let is_on = |x: usize| {
            let first = (x as f64 * rise_per_cell).round() as i32 + 2;
            (first..first + thick).contains(&y)
        };
        (0..width).map(|x| if is_on(x) { '#' } else { '.' }).collect()
    };
    map(&(0..height).rev().map(row).collect::<Vec<String>>())
}

fn traced(map: &RosMap) -> Traced {
    let traced = trace(map, "map").unwrap();
    traced.world.check().unwrap();
    assert!(traced.max_deviation_cells <= TOLERANCE_CELLS);
    traced
}

/// The corners of the walls in cells of the map, sorted.
fn corners(map: &RosMap) -> Vec<[f64; 2]> {
    let traced = traced(map);
    let cell = |wall: &WallSpec| {
        [(wall.a[0] - map.origin_m[0]) / map.cell_m, (wall.a[1] - map.origin_m[1]) / map.cell_m]
    };
    let mut corners: Vec<[f64; 2]> = traced.world.walls.iter().map(cell).collect();
    corners.sort_by(|p, q| p.partial_cmp(q).unwrap());
    corners
}

#[test]
fn a_room_keeps_its_corners_and_its_walls_their_thickness() {
    let room = drawn(&["........", ".######.", ".#....#.", ".#....#.", ".######.", "........"]);
    let Traced { world, occupied_cells, outlines, cell_corners, max_deviation_cells } =
        traced(&room);
    assert_eq!((occupied_cells, outlines, cell_corners), (16, 2, 8));
    assert_eq!((world.walls.len(), max_deviation_cells), (8, 0.0));
    let expected =
        [[1, 1], [1, 5], [2, 2], [2, 4], [6, 2], [6, 4], [7, 1], [7, 5]].map(|c| c.map(f64::from));
    assert_eq!(corners(&room), expected);
    assert_eq!(world.bounds, [-0.6, 2.4, 2.6, 4.6]);
    // From the middle of the room to its inner faces.
    let world = World::new(world).unwrap();
    let distance = |angle| world.raycast(Point2::new(1.0, 3.5), angle, 10.0).distance_m;
    assert_eq!((distance(0.0), distance(core::f64::consts::PI)), (1.0, 1.0));
}

#[test]
fn thin_walls_and_single_cells_stay_rectangles() {
    let across = drawn(&[&format!("#{}", "#".repeat(29))]);
    assert_eq!(corners(&across), [[0.0, 0.0], [0.0, 1.0], [30.0, 0.0], [30.0, 1.0]]);
    let block = drawn(&["##", "##"]);
    assert_eq!(corners(&block), [[0.0, 0.0], [0.0, 2.0], [2.0, 0.0], [2.0, 2.0]]);
    let cell = drawn(&["...", ".#.", "..."]);
    assert_eq!(corners(&cell), [[1.0, 1.0], [1.0, 2.0], [2.0, 1.0], [2.0, 2.0]]);
    // A wall of one cell that ends in a room.
    let stub = drawn(&["##########", "####.#####", "####.#####", "####.#####", "##########"]);
    let slit = [[4.0, 1.0], [4.0, 4.0], [5.0, 1.0], [5.0, 4.0]];
    assert!(slit.iter().all(|corner| corners(&stub).contains(corner)));
}

#[test]
fn a_bump_of_a_cell_leaves_a_straight_wall_straight() {
    let bump = drawn(&["....................", ".........#..........", "####################"]);
    assert_eq!(corners(&bump), [[0.0, 0.0], [0.0, 1.0], [20.0, 0.0], [20.0, 1.0]]);
    assert_eq!(traced(&bump).max_deviation_cells, 1.0);
}

#[test]
fn slanted_walls_become_a_few_long_walls_that_no_beam_passes() {
    for (rise, thick) in [(0.05, 1), (0.05, 3), (0.3, 2), (0.5, 1), (1.0, 1), (1.0, 2)] {
        let map = line(120, rise, thick);
        let traced = traced(&map);
        assert!(traced.world.walls.len() <= 8, "{rise}: {}", traced.world.walls.len());
        assert_eq!(traced.outlines, 1, "{rise}");
        let direction = trig::atan2(rise, 1.0);
        let is_along = |wall: &WallSpec| {
            let angle = trig::atan2(wall.b[1] - wall.a[1], wall.b[0] - wall.a[0]) - direction;
            trig::sin(angle).abs() < 0.02
        };
        let walls = traced.world.walls.iter().filter(|wall| is_along(wall));
        let long_m: f64 = walls.map(|wall| Wall::from(wall).length_m()).sum();
        let line_m = 60.0 * (1.0 + rise * rise).sqrt();
        assert!(long_m > 1.8 * line_m, "{rise}: {long_m} of twice {line_m} m");
        let world = World::new(traced.world).unwrap();
        for k in 1..595 {
            let above = Point2::new(-1.0 + 0.1 * f64::from(k), 1e3);
            let hit = world.raycast(above, -core::f64::consts::FRAC_PI_2, 2e3);
            assert!(hit.material.is_some(), "{rise}, beam {k}");
        }
    }
}

#[test]
fn a_turned_map_is_turned() {
    let mut room = drawn(&["##", "##"]);
    room.yaw_rad = core::f64::consts::FRAC_PI_2;
    let walls = traced(&room).world.walls;
    let mut ends: Vec<[f64; 2]> = walls.iter().map(|wall| wall.a).collect();
    ends.sort_by(|p, q| p.partial_cmp(q).unwrap());
    assert_eq!(ends, [[-2.0, 2.0], [-2.0, 3.0], [-1.0, 2.0], [-1.0, 3.0]]);
}

#[test]
fn random_maps_are_closed_and_within_the_tolerance_in_both_directions() {
    let mut state = 1_u64;
    let mut random = || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / (1_u64 << 31) as f64
    };
    for case in 0..60 {
        let density = random();
        let row = |_| (0..24).map(|_| if random() < density { '#' } else { '.' }).collect();
        let map = map(&(0..17).map(row).collect::<Vec<String>>());
        let Ok(Traced { world, .. }) = trace(&map, "random") else { continue };
        assert_eq!(world.check(), Ok(()), "case {case}");
        // Closed: as many walls begin at a corner as end there.
        let sorted = |of: fn(&WallSpec) -> [f64; 2]| {
            let mut ends: Vec<_> = world.walls.iter().map(of).collect();
            ends.sort_by(|p, q| p.partial_cmp(q).unwrap());
            ends
        };
        assert_eq!(sorted(|wall| wall.a), sorted(|wall| wall.b), "case {case}");
        let occupied = |x: i32, y: i32| Occupied { map: &map, height: 17 }.at(x, y);
        let edges: Vec<Wall> = (0..18 * 25)
            .map(|k| (k % 25, k / 25))
            .flat_map(|(x, y)| {
                let flat = (occupied(x, y) != occupied(x, y - 1)).then_some([x, y, x + 1, y]);
                let steep = (occupied(x, y) != occupied(x - 1, y)).then_some([x, y, x, y + 1]);
                flat.into_iter().chain(steep)
            })
            .map(|ends| {
                let [ax, ay, bx, by] = ends.map(|v| 0.5 * f64::from(v));
                let (a, b) = (Point2::new(ax - 1.0, ay + 2.0), Point2::new(bx - 1.0, by + 2.0));
                Wall { a, b, material: Material::Wall }
            })
            .collect();
        let walls = world.to_walls();
        let far = |from: &[Wall], to: &[Wall]| {
            let middle = |wall: &Wall| wall.a + 0.5 * (wall.b - wall.a);
            let points = from.iter().flat_map(|wall| [wall.a, middle(wall), wall.b]);
            let nearest = |point| to.iter().map(|w| w.distance(&point)).fold(f64::MAX, f64::min);
            points.map(nearest).fold(0.0, f64::max) / 0.5
        };
        assert!(far(&walls, &edges) <= TOLERANCE_CELLS + 1e-9, "case {case}");
        assert!(far(&edges, &walls) <= TOLERANCE_CELLS + 1e-9, "case {case}");
    }
}

#[test]
fn a_map_without_walls_or_with_too_many_is_named() {
    let error = trace(&drawn(&["..", ".."]), "map").unwrap_err().to_string();
    assert!(error.contains("occupied cells = 0") && error.contains("`negate`"), "{error}");
    let dot = |x: usize, y: usize| if (x | y).is_multiple_of(2) { '#' } else { '.' };
    let dots = |y| (0..800).map(|x| dot(x, y)).collect();
    let error = trace(&map(&(0..800).map(dots).collect::<Vec<String>>()), "map").unwrap_err();
    assert!(error.to_string().contains("more than 100000 walls"), "{error}");
}
