//! World files of every format by their paths, and the check of floor plans.

use std::fs;

use ::png::{BitDepth, ColorType, Encoder};
use rusty_geometry::{Material, apartment, hallway};

use super::check::{Kind, Report, check};
use super::*;

const PAGE: &str = "image: map.pgm\nresolution: 0.05\norigin: [-1.0, 2.5, 0.0]\nnegate: 0\n\
                    occupied_thresh: 0.65\nfree_thresh: 0.196\n";

/// The pixels of a room of 12 × 9 cells with a door, from the upper row: 0 is black.
fn room() -> Vec<u8> {
    let is_wall = |x: i32, y: i32| (x == 1 || x == 10 || y == 1 || y == 7) && !(x == 5 && y == 7);
    let inside = |x: i32, y: i32| (1..=10).contains(&x) && (1..=7).contains(&y);
    let grey = |x, y| if inside(x, y) { if is_wall(x, y) { 0 } else { 254 } } else { 205 };
    (0..9).flat_map(|y| (0..12).map(move |x| grey(x, y))).collect()
}

fn png(colour: ColorType, samples: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, 12, 9);
    encoder.set_color(colour);
    encoder.set_depth(BitDepth::Eight);
    encoder.write_header().unwrap().write_image_data(samples).unwrap();
    bytes
}

/// The world of a page and its picture.
fn of(page: &str, picture: &[u8]) -> Result<WorldSpec, String> {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("map.pgm"), picture).unwrap();
    let yaml = folder.path().join("lab.yaml");
    fs::write(&yaml, page).unwrap();
    read(&yaml).map_err(|error| error.to_string())
}

#[test]
fn every_picture_of_a_map_gives_the_same_walls() {
    let grey = room();
    let plain = of(PAGE, &map_server::pgm::write(12, 9, "room", &grey)).unwrap();
    assert_eq!((plain.name.as_str(), plain.walls.len()), ("lab", 12));
    assert!(plain.walls.iter().all(|wall| wall.material == Material::Wall));
    // The upper row of the picture is the far one of the map: the door is in the south.
    assert_eq!(plain.bounds, [-1.05, 2.45, -0.35, 3.0]);
    let each = |change: fn(&u8) -> Vec<u8>| grey.iter().flat_map(change).collect::<Vec<u8>>();
    let numbers: String = grey.iter().map(|v| format!("{v} ")).collect();
    for picture in [
        format!("P2\n12 9\n255\n{numbers}").into_bytes(),
        png(ColorType::Grayscale, &grey),
        png(ColorType::GrayscaleAlpha, &each(|v| vec![*v, 9])),
        png(ColorType::Rgb, &each(|v| vec![*v; 3])),
        png(ColorType::Rgba, &each(|v| vec![*v, *v, *v, 255])),
    ] {
        assert_eq!(of(PAGE, &picture).unwrap(), plain);
    }
    let negative: Vec<u8> = grey.iter().map(|v| 255 - v).collect();
    let picture = map_server::pgm::write(12, 9, "room", &negative);
    assert_eq!(of(&PAGE.replace("negate: 0", "negate: 1"), &picture).unwrap(), plain);
}

#[test]
fn a_map_that_cannot_be_used_is_named() {
    let picture = map_server::pgm::write(12, 9, "room", &room());
    let whole = png(ColorType::Grayscale, &room());
    let with = |from: &str, to: &str| PAGE.replace(from, to);
    for (page, picture, words) in [
        (with("0.05", "0"), &picture[..], "lab.yaml: resolution = 0: is out of range"),
        (with("map.pgm", "none.pgm"), &picture, "lab.yaml: image = none.pgm: "),
        (with("0.0]", "9.0]"), &picture, "lab.yaml: origin[2] = 9: is out of range"),
        (format!("{PAGE}mode: raw\n"), &picture, "lab.yaml: mode = raw: "),
        (with("image", "picture"), &picture, "lab.yaml: "),
        (with("0.65", "1.0"), &picture, "lab.yaml: occupied cells = 0: "),
        (PAGE.to_owned(), &picture[..40], "map.pgm: bytes of pixels = "),
        (PAGE.to_owned(), &whole[..40], "map.pgm: PNG = "),
        (PAGE.to_owned(), b"GIF89a", "map.pgm: first two bytes = GI: "),
    ] {
        let error = of(&page, picture).unwrap_err();
        assert!(error.contains(words), "{error}, not {words}");
    }
}

#[test]
fn the_ending_decides_and_a_wrong_name_gets_a_suggestion() {
    let folder = tempfile::tempdir().unwrap();
    let plan = hallway().spec().clone();
    let svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"4cm\" height=\"3cm\">\
               <path d=\"M0 0H9\" stroke=\"black\"/></svg>";
    let texts = [
        ("a.json", plan.to_json().unwrap()),
        ("a.toml", plan.to_toml().unwrap()),
        ("a.TXT", plan.to_toml().unwrap()),
    ];
    for (name, text) in texts {
        let path = folder.path().join(name);
        fs::write(&path, text).unwrap();
        assert_eq!(read(&path).unwrap(), plan, "{name}");
    }
    let path = folder.path().join("floor 1.SVG");
    fs::write(&path, svg).unwrap();
    assert_eq!(read(&path).unwrap().name, "floor 1");
    let error = world("apartmnt").unwrap_err().to_string();
    assert!(error.ends_with("did you mean \"apartment\"?"), "{error}");
    assert_eq!(world("hallway").unwrap(), plan);
    let gap = "<svg xmlns='http://www.w3.org/2000/svg' width='4m' data-metres-per-unit='0.01' \
               viewBox='0 0 400 300'><path d='M0 0H100M102 1V50' stroke='black'/></svg>";
    fs::write(&path, gap).unwrap();
    let error = read(&path).unwrap_err().to_string();
    assert!(error.contains("floor 1.SVG: ") && error.contains("stops 2.2"), "{error}");
}

fn plan(walls: &[[f64; 4]]) -> WorldSpec {
    let wall = |&[ax, ay, bx, by]: &[f64; 4]| WallSpec {
        a: [ax, ay],
        b: [bx, by],
        material: Material::Wall,
    };
    let walls: Vec<WallSpec> = walls.iter().map(wall).collect();
    WorldSpec { name: "plan".to_owned(), bounds: bounds_of(&walls), walls, landmarks: Vec::new() }
}

fn kinds(report: &Report) -> Vec<Kind> {
    report.findings.iter().map(|found| found.kind).collect()
}

const BOX: [[f64; 4]; 4] =
    [[0.0, 0.0, 4.0, 0.0], [4.0, 0.0, 4.0, 3.0], [4.0, 3.0, 0.0, 3.0], [0.0, 3.0, 0.0, 0.0]];

#[test]
fn the_built_in_floors_are_closed() {
    for (world, loose) in [(apartment(), 13), (hallway(), 0)] {
        let report = check(world.spec(), None).unwrap();
        assert_eq!((report.problems(), report.findings.len()), (0, loose), "{report}");
        assert!(report.floor_m.is_some());
    }
    let open = check(rusty_geometry::open().spec(), None).unwrap();
    assert_eq!((open.findings.len(), open.floor_m), (0, None));
}

#[test]
fn an_opening_is_found_where_it_is_and_as_wide_as_it_is() {
    // A room with a door of 0.8 m in the south, and one of 0.5 m in the west.
    let rest =
        [[0.0, 0.0, 1.0, 0.0], [1.8, 0.0, 4.0, 0.0], [0.0, 3.0, 0.0, 2.0], [0.0, 1.5, 0.0, 0.0]];
    let spec = plan(&[&BOX[1..3], &rest].concat());
    let report = check(&spec, None).unwrap();
    let openings: Vec<_> =
        report.findings.iter().filter(|found| found.kind == Kind::Opening).collect();
    assert_eq!(openings.len(), 2, "{report}");
    for (found, at, width) in [(openings[0], [1.4, 0.0], 0.8), (openings[1], [0.0, 1.75], 0.5)] {
        let off = (found.at_m[0] - at[0]).abs().max((found.at_m[1] - at[1]).abs());
        assert!(off < 2.0 * report.resolution_m, "{found:?}");
        assert!((found.length_m - width).abs() < 3.0 * report.resolution_m, "{found:?}");
    }
    assert_eq!(report.problems(), 2);
    // Seen from the start pose: a point in the field is on no floor.
    assert_eq!(check(&spec, Some([2.0, 1.5])).unwrap().problems(), 2);
    assert_eq!(check(&spec, Some([-0.05, 1.0])).unwrap().floor_m, None);
    assert_eq!(check(&spec, Some([99.0, 1.0])).unwrap().floor_m, None);
}

#[test]
fn gaps_loose_ends_and_overlaps_are_named_with_their_walls() {
    let inner = [[1.0, 1.0, 2.0, 1.0], [3.98, 2.0, 3.0, 2.0], [1.0, 3.0, 2.5, 3.0]];
    let report = check(&plan(&[&BOX[..], &inner].concat()), None).unwrap();
    let expected = [Kind::Gap, Kind::LooseEnd, Kind::LooseEnd, Kind::LooseEnd, Kind::Overlap];
    assert_eq!(kinds(&report), expected, "{report}");
    let [gap, first, _, _, overlap] = &report.findings[..] else { panic!("{report}") };
    assert_eq!((gap.at_m, &gap.walls), ([3.98, 2.0], &vec![5, 1]));
    assert!((gap.length_m - 0.02).abs() < 1e-9);
    assert_eq!((first.at_m, first.length_m, &first.walls), ([1.0, 1.0], 1.0, &vec![4, 0]));
    assert_eq!((overlap.at_m, overlap.length_m), ([1.75, 3.0], 1.5));
    assert_eq!(overlap.walls, [2, 6]);
    assert_eq!(report.problems(), 2);
    assert_eq!(kinds(&check(&plan(&BOX), None).unwrap()), []);
    // Slanted, drawn in opposite directions, and end to end.
    let slanted = [[0.0, 0.0, 4.0, 3.0], [3.2, 2.4, 0.8, 0.6], [4.0, 3.0, 8.0, 6.0]];
    let report = check(&plan(&slanted), None).unwrap();
    let overlaps: Vec<_> = report.findings.iter().filter(|f| f.kind == Kind::Overlap).collect();
    assert_eq!(overlaps.len(), 1, "{report}");
    assert!((overlaps[0].length_m - 3.0).abs() < 1e-9);
    let far = plan(&[[0.0, 0.0, f64::NAN, 0.0]]);
    assert!(matches!(
        check(&far, None),
        Err(WorldError::NotFinite { .. } | WorldError::Bounds { .. })
    ));
}

#[test]
fn more_findings_than_are_named_are_no_total() {
    let wall = |k: u32| format!("[[walls]]\na = [{k}, 1]\nb = [{k}, 2]\nmaterial = \"Wall\"\n");
    let walls: String = (1..=600).map(wall).collect();
    let text = |count: usize| {
        let walls = &walls[..walls.match_indices("[[").nth(count).map_or(walls.len(), |at| at.0)];
        format!("name = \"combs\"\nbounds = [0, 0, 700, 3]\n{walls}")
    };
    for (count, said) in [(400, " 800 loose ends"), (600, "at least 1000 loose ends")] {
        let report = check(&WorldSpec::from_toml_str(&text(count)).unwrap(), None).unwrap();
        assert!(
            report.to_string().contains(said),
            "{}",
            report.to_string().lines().last().unwrap()
        );
    }
}
