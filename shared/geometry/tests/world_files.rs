//! World files: reading, writing, and every reason to refuse one.
#![allow(clippy::unwrap_used)]

use rusty_geometry::{Material, WallSpec, World, WorldError, WorldSpec, apartment, hallway, open};

const BOX: &str = r#"
name = "box"
bounds = [0, 0, 4.0, 3.0]

[[walls]]
a = [0, 0]
b = [4.0, 0.0]
material = "Glass"

[[walls]]
a = [4.0, 0.0]
b = [4.0, 3.0]
material = "Door(7)"
"#;

fn spec(walls: &[([f64; 2], [f64; 2])]) -> WorldSpec {
    WorldSpec {
        name: "plan".to_owned(),
        bounds: [0.0, 0.0, 10.0, 10.0],
        walls: walls
            .iter()
            .map(|(a, b)| WallSpec { a: *a, b: *b, material: Material::Wall })
            .collect(),
        landmarks: Vec::new(),
    }
}

/// The error of a plan, whose text must name all of `parts`.
fn refused(spec: WorldSpec, parts: &[&str]) -> WorldError {
    let error = World::new(spec).unwrap_err();
    let text = error.to_string();
    for part in parts {
        assert!(text.contains(part), "{part:?} is not in {text:?}");
    }
    error
}

#[test]
fn toml_and_json_read_back_to_the_same_bits() {
    let from_toml = WorldSpec::from_toml_str(BOX).unwrap();
    assert_eq!(from_toml.walls[0].material, Material::Glass);
    assert_eq!(from_toml.walls[1].material, Material::Door(7));
    for spec in [&from_toml, apartment().spec(), hallway().spec(), open().spec()] {
        assert_eq!(&WorldSpec::from_toml_str(&spec.to_toml().unwrap()).unwrap(), spec);
        assert_eq!(&WorldSpec::from_json_str(&spec.to_json().unwrap()).unwrap(), spec);
    }
}

#[test]
fn what_is_not_a_world_file_says_where() {
    let unknown = BOX.replace("name", "colour = \"red\"\nname");
    let text = WorldSpec::from_toml_str(&unknown).unwrap_err().to_string();
    assert!(text.contains("TOML") && text.contains("colour"), "{text}");
    let brick = BOX.replace("Glass", "Brick");
    let text = WorldSpec::from_toml_str(&brick).unwrap_err().to_string();
    assert!(text.contains("Brick") && text.contains("Door(n)"), "{text}");
    let text = WorldSpec::from_json_str("{\"name\":\"x\"}").unwrap_err().to_string();
    assert!(text.contains("JSON") && text.contains("bounds"), "{text}");
    assert!(WorldSpec::from_toml_str("name = \"x\"\nbounds = [0, 0, 1, 1]").is_err());
}

#[test]
fn names_and_bounds() {
    for name in ["", "a\nb", &"x".repeat(65)] {
        let named = WorldSpec { name: name.to_owned(), ..spec(&[]) };
        assert!(matches!(refused(named, &["name", "1 to 64"]), WorldError::Name { .. }));
    }
    for bounds in [
        [0.0, 0.0, 0.0, 1.0],
        [0.0, 2.0, 1.0, 1.0],
        [f64::NAN, 0.0, 1.0, 1.0],
        [0.0, 0.0, f64::INFINITY, 1.0],
        [0.0, 0.0, 1.0, 2e6],
    ] {
        let bounded = WorldSpec { bounds, ..spec(&[]) };
        let error = refused(bounded, &["\"plan\"", "bounds", "x_min < x_max"]);
        assert!(matches!(error, WorldError::Bounds { .. }));
    }
}

#[test]
fn walls_by_themselves() {
    let good = ([1.0, 1.0], [2.0, 1.0]);
    let error = refused(spec(&[good, ([3.0, f64::NAN], [4.0, 4.0])]), &["wall 1", "NaN"]);
    assert!(matches!(error, WorldError::NotFinite { wall: 1, .. }));
    let error = refused(spec(&[good, ([3.0, 3.0], [3.0, 3.000_000_9])]), &["wall 1", "1e-6"]);
    assert!(matches!(error, WorldError::TooShort { wall: 1, .. }));
    let error = refused(spec(&[good, ([3.0, 3.0], [10.5, 3.0])]), &["wall 1", "end `b`", "10.5"]);
    assert!(matches!(error, WorldError::OutOfBounds { wall: 1, end: 'b', .. }));
    let many = spec(&vec![good; 100_001]);
    assert!(matches!(refused(many, &["100001", "100000"]), WorldError::TooManyWalls { .. }));
}

#[test]
fn a_slip_of_the_pen_is_a_gap() {
    let through = ([0.0, 5.0], [10.0, 5.0]);
    let stops_short = |y: f64| spec(&[through, ([5.0, 0.0], [5.0, y])]);
    let remedy = "snap it onto that wall, or move it farther than 0.05 m";
    for y in [4.97, 4.999_999, 4.999_999_99, 5.02] {
        let plan = stops_short(y);
        let gaps = plan.gaps().unwrap();
        assert_eq!(gaps.len(), 1, "{y}");
        assert_eq!((gaps[0].wall, gaps[0].end, gaps[0].other), (1, 'b', 0));
        assert!((gaps[0].distance_m - (5.0 - y).abs()).abs() < 1e-12);
        let error = refused(plan, &["wall 1", "end `b`", "from wall 0", remedy]);
        assert!(matches!(error, WorldError::Gap { .. }));
    }
    for y in [5.0, 5.0 - 1e-10, 4.94, 5.06, 3.0] {
        assert!(stops_short(y).gaps().unwrap().is_empty(), "{y}");
        assert!(World::new(stops_short(y)).is_ok(), "{y}");
    }
}

#[test]
fn a_corner_that_almost_closes_is_two_gaps() {
    let corner = spec(&[([1.0, 1.0], [4.0, 1.0]), ([4.01, 1.01], [4.0, 4.0])]);
    let ends: Vec<_> = corner.gaps().unwrap().iter().map(|gap| (gap.wall, gap.end)).collect();
    assert_eq!(ends, [(0, 'b'), (1, 'a')]);
}

#[test]
fn the_places_have_no_gaps() {
    for world in [open(), hallway(), apartment()] {
        assert_eq!(world.spec().gaps().unwrap(), []);
        assert_eq!(world.spec().check(), Ok(()));
    }
}

#[test]
fn a_large_plan_is_checked_quickly() {
    // 40 000 walls in long lines; comparing every pair would take minutes.
    let lines: Vec<_> = (0..40_000)
        .map(|k| (f64::from(k % 200), f64::from(k / 200)))
        .map(|(i, j)| ([0.3 * i, 0.3 * j], [0.3 * i, 0.3 * (j + 1.0)]))
        .collect();
    let spec = WorldSpec { bounds: [-1.0, -1.0, 61.0, 61.0], ..spec(&lines) };
    assert_eq!(spec.check(), Ok(()));
}
