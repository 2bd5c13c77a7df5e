//! Worlds from elsewhere: maps of ROS and drawings, as the programs take them.

use nalgebra::Point2;
use rusty_filters::OccupancyMap;
use rusty_floorplan::trace::TOLERANCE_CELLS;
use rusty_geometry::{World, apartment};
use rusty_tests::*;

const CELL_M: f64 = 0.05;

/// The Apartment as a map of ROS, and the path of its page.
fn apartment_map(place: &Folder) -> PathBuf {
    let stem = place.at("flat");
    OccupancyMap::of_world(&apartment(), 0.2, CELL_M).save(&stem).unwrap();
    stem.with_extension("yaml")
}

/// Distances of points along the walls of one world from the walls of another, m.
fn distances(from: &World, to: &World) -> Vec<f64> {
    let along = |k: i32| f64::from(k) / 50.0;
    let points = from
        .walls()
        .iter()
        .flat_map(|wall| (0..=50).map(move |k| wall.a + along(k) * (wall.b - wall.a)));
    points.map(|point| to.distance_to_nearest(point)).collect()
}

#[test]
fn a_traced_map_has_the_walls_that_the_map_was_made_of() {
    let place = folder();
    let original = apartment();
    let traced = World::new(rusty_floorplan::read(&apartment_map(&place)).unwrap()).unwrap();
    assert!(traced.walls().len() < 300, "{}", traced.walls().len());
    // A cell with a piece of wall in it is occupied, and its farthest corner is a
    // diagonal away.
    let most_m = CELL_M * (TOLERANCE_CELLS + std::f64::consts::SQRT_2);
    for (from, to) in [(&original, &traced), (&traced, &original)] {
        let distances = distances(from, to);
        assert!(distances.iter().all(|m| *m <= most_m), "{:?}", spread(distances));
    }
    // What a robot sees in the two differs by the thickness of the walls.
    let mut off_m = Vec::new();
    for (x, y) in [(1.0, 4.5), (6.0, 4.5), (10.5, 4.5), (2.0, 7.0), (9.0, 1.5)] {
        for k in 0..90 {
            let angle_rad = 0.07 * f64::from(k);
            let range = |world: &World| world.raycast(Point2::new(x, y), angle_rad, 20.0);
            off_m.push((range(&original).distance_m - range(&traced).distance_m).abs());
        }
    }
    let (rms_m, most_m) = spread(off_m);
    assert!(most_m < 0.2, "{rms_m} m, 95 % within {most_m} m");
}

#[test]
fn a_run_in_a_traced_map_repeats_without_the_map() {
    let place = folder();
    let yaml = apartment_map(&place);
    let world = format!("world_file={}", yaml.display());
    let out = place.at("run");
    let report = launch("traced", &out, &["--ticks", "200", "--set", &world]);
    let csv = place.at("t.csv");
    let sweep = ["sweep", "--seeds", "0..2", "--ticks", "50", "--set", &world, "--out", arg(&csv)];
    sim_server(&sweep).expect(0);
    // The log has the walls.
    for file in ["flat.yaml", "flat.pgm"] {
        fs::remove_file(place.at(file)).unwrap();
    }
    let log = log_of(&report);
    assert_eq!(Log::read(&log).header.config.world.name, "flat");
    sim_server(&["verify", arg(&log)]).expect(0);
    let again = replay(&log, &place.at("again"), &[]).expect(0).json();
    assert_eq!(again["digest"], report["digest"]);
}

const DRAWING: &str = "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 400 300' \
                       data-metres-per-unit='0.01'><path d='M0 0H400V300H0Z' fill='none' \
                       stroke='black'/><line class='door-3' x1='100' y1='0' x2='100' y2='80'/></svg>";

#[test]
fn a_drawing_is_a_world_for_every_verb() {
    let place = folder();
    let svg = place.write("plan.svg", DRAWING);
    let converted = sim_server(&["worlds", &svg, "--json"]).expect(0).stdout;
    let json = place.write("plan.json", &converted);
    assert!(converted.contains("Door(3)"), "{converted}");
    let digest = |file: &str| {
        let world = format!("world_file={file}");
        let start = "start={ x_m = 2.0, y_m = 1.5, theta_rad = 0.0 }";
        let set = ["--set", &world, "--set", "script.kind=figure-eight", "--set", start];
        let report = launch("drawn", &place.at("run"), &[&["--ticks", "50"], &set[..]].concat());
        text(&report, "digest").to_owned()
    };
    assert_eq!(digest(&svg), digest(&json), "the converted world is the same");
    sim_server(&["worlds", &svg, "--scan", "2,1.5,0"]).expect(0).prints("Door(3)");
    sim_server(&["launch", &svg]).expect(2).says("--set world_file=");
    let plain = place.write("px.svg", DRAWING.replace("data-metres-per-unit='0.01'", ""));
    let world = format!("world_file={plain}");
    for args in [&["worlds", &plain][..], &["launch", "--set", &world]] {
        sim_server(args).expect(2).says("px.svg: ").says("data-metres-per-unit=\"0.01\"");
    }
}

/// A scan with noise is the first of a run with that seed, bit for bit.
#[test]
fn a_scan_with_noise_is_that_of_a_run_in_the_same_place() {
    let (_out, log) = logged("scan", &["anatomy", "--ticks", "1", "--seed", "7"]);
    let ranges = Log::read(&log).records()[0].ranges_m.clone();
    let pose = "4.9,2.84,1.5707963267948966";
    let all = ["worlds", "apartment", "--scan", pose, "--noise", "--seed", "7", "--json"];
    let scan = sim_server(&all).expect(0).json();
    let said = |key: &str| list(&scan, key).iter().map(|m| m.as_f64().unwrap()).collect::<Vec<_>>();
    assert_eq!(Some(said("measured")), ranges);
    assert_eq!(said("ranges")[90], 2.26);
    assert_eq!(scan["cliffs"], json!([6, 78, 103]));
    assert_eq!(list(&scan, "bearings_rad").len(), list(&scan, "ranges").len());
}

#[test]
fn the_examples_of_the_page_can_be_used() {
    let page = fs::read_to_string(repository().join("docs/worlds.md")).unwrap();
    let block = |fence: &str| page.split(fence).nth(1).unwrap().split("```").next().unwrap();
    let place = folder();
    let svg = place.write("plan.svg", block("```xml\n"));
    let report = sim_server(&["worlds", &svg, "--check", "--json"]).expect(0).json();
    assert_eq!((list(&report, "findings").len(), &report["world"]), (0, &"plan".into()));
    let walls = rusty_floorplan::read(Path::new(&svg)).unwrap().walls;
    let materials: Vec<String> = walls.iter().map(|wall| wall.material.to_string()).collect();
    assert_eq!(materials, ["Wall", "Wall", "Wall", "Wall", "Glass", "Door(3)"]);
    let yaml = place.write("lab.yaml", block("```yaml\n"));
    place.write("lab.pgm", "P2 3 3 255 254 254 254 254 0 254 205 205 205");
    assert_eq!(rusty_floorplan::read(Path::new(&yaml)).unwrap().walls.len(), 4);
}

#[test]
fn a_check_names_what_is_wrong_and_where_and_its_code_says_whether() {
    let place = folder();
    sim_server(&["worlds", "apartment", "--check"]).expect(0).prints("0 problems");
    let svg = place.write("plan.svg", DRAWING);
    // The door that ends in the room is a loose end.
    sim_server(&["worlds", &svg, "--check"]).expect(0).prints("loose end at (1.000, 2.200) m");
    let open = place.write("open.svg", DRAWING.replace("H400V300H0Z", "H400V300H200M100 300H0V0"));
    let report = sim_server(&["worlds", &open, "--check", "--json"]).expect(1).json();
    let opening = list(&report, "findings").iter().find(|found| found["kind"] == "opening");
    let at = |axis: &str| number(opening.unwrap(), axis);
    assert!((at("at_m.0") - 1.5).abs() < 0.1 && at("at_m.1").abs() < 0.1, "{report}");
    assert!((at("length_m") - 1.0).abs() < 0.15, "{report}");
    let gap = place.write("gap.svg", DRAWING.replace("y1='0'", "y1='2'"));
    sim_server(&["worlds", &gap]).expect(2).says("gap.svg: ");
    let report = sim_server(&["worlds", &gap, "--check", "--json"]).expect(1).json();
    let found = &list(&report, "findings")[0];
    assert_eq!(found["kind"], "gap");
    assert!((number(found, "length_m") - 0.02).abs() < 1e-6, "{found}");
    sim_server(&["worlds", &svg, "--check", "--start", "1"]).expect(2).says("--start 1: ");
    // A mistyped place is not closed.
    let report = ["worlds", "apartment", "--check", "--start", "99,3", "--json"];
    let report = sim_server(&report).expect(1).json();
    let openings: Vec<&Value> =
        report["findings"].as_array().unwrap().iter().filter(|f| f["kind"] == "opening").collect();
    assert_eq!((openings.len(), &openings[0]["at_m"]), (1, &serde_json::json!([99.0, 3.0])));
    sim_server(&["worlds", "apartment", "--scan", "99,3,0"]).expect(2).says("--scan 99,3,0: ");
    sim_server(&["worlds", "nowhere.svg", "--check"]).expect(2).says("nowhere.svg: No such file");
}

#[test]
fn a_real_map_is_traced_drawn_and_driven_in() {
    let Some(yaml) = real_data("turtlebot3-map.yaml") else { return };
    let place = folder();
    let svg = place.at("map.svg");
    let drawn = sim_server(&["worlds", arg(&yaml), "--svg", arg(&svg)]).expect(0);
    drawn.says("795 occupied cells, 14 outlines with 740 corners: ");
    // The cells are below the walls.
    let picture = fs::read_to_string(&svg).unwrap();
    let (cells, walls) = (picture.find("<polygon").unwrap(), picture.rfind("<polyline").unwrap());
    assert!(cells < walls);
    let found = rusty_floorplan::map_of(&yaml).unwrap().unwrap();
    assert!(found.traced.max_deviation_cells <= TOLERANCE_CELLS);
    assert!(found.traced.world.walls.len() < 200, "{}", found.traced.world.walls.len());
    // The nine columns of the arena are a metre apart.
    let world = World::new(found.traced.world).unwrap();
    for (x, y) in [-1.1, 0.0, 1.1].into_iter().flat_map(|x| [-1.1, 0.0, 1.1].map(|y| (x, y))) {
        assert!(world.distance_to_nearest(Point2::new(x, y)) < 0.2, "({x}, {y})");
    }
    let file = format!("world_file={}", yaml.display());
    let start = "start={ x_m = -2.0, y_m = 0.5, theta_rad = 1.57 }";
    let set = ["--set", &file, "--set", "script.kind=figure-eight", "--set", start];
    let report = launch("arena", &place.at("run"), &[&["--ticks", "50"], &set[..]].concat());
    sim_server(&["verify", arg(&log_of(&report))]).expect(0);
}
