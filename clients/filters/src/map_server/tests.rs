//! Maps that were written are read again; what others write is read or refused.

use std::fs;

use rusty_floorplan::map_server::beside;

use super::*;
use crate::Cell;

const PAGE: &str = "image: map.pgm\nresolution: 0.05\norigin: [-10.0, 2.5, 0.0]\nnegate: 0\n\
                    occupied_thresh: 0.65\nfree_thresh: 0.196\n";

/// A folder with a page and a picture of 3 × 2: black, unknown, white; unknown,
/// black, black.
fn folder(page: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("map.pgm"), b"P5 3 2 255\n\x00\xcd\xfe\xcd\x00\x00").unwrap();
    fs::write(folder.path().join("map.yaml"), page).unwrap();
    folder
}

fn load(page: &str) -> Result<OccupancyMap, ClientError> {
    let folder = folder(page);
    OccupancyMap::load(&folder.path().join("map.yaml"))
}

#[test]
fn the_upper_row_of_the_picture_is_the_far_one_of_the_map() {
    use Cell::{Free, Occupied, Unknown};
    let map = load(PAGE).unwrap();
    assert_eq!((map.frame.width, map.frame.height, map.frame.cell_m), (3, 2, 0.05));
    assert_eq!(map.cells, [Unknown, Occupied, Occupied, Occupied, Unknown, Free]);
    assert_eq!(map.at(Point2::new(-9.99, 2.51)), Unknown);
    assert_eq!(map.at(Point2::new(-9.87, 2.58)), Free);
}

#[test]
fn pages_of_others_are_read() {
    let plain = load(PAGE).unwrap();
    for page in [
        "# saved by hand\nimage: ./map.pgm   # the picture\nresolution: 0.050000\norigin:\n  - -10\n  \
         - 2.5e0\n  - 0\nnegate: false\noccupied_thresh: 0.65\nfree_thresh: 0.196\nmode: scale\n",
        "{\"image\": 'map.pgm', resolution: 5e-2, origin: [-10.000000, 2.500000, 0.000000], \
         negate: 0, occupied_thresh: 0.65, free_thresh: 0.196, author: nobody}",
    ] {
        assert_eq!(load(page).unwrap(), plain, "{page}");
    }
    let negated = load(&PAGE.replace("negate: 0", "negate: 1")).unwrap();
    // 205 of 255 is 0.80 now: above the threshold.
    assert_eq!(negated.cells[2], Cell::Free);
    assert_eq!(negated.cells[4], Cell::Occupied);
}

#[test]
fn a_map_is_its_files_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = crate::Random::new(3, 1);
    for k in 0..50 {
        let mut any = |most: f64| random.uniform() * most;
        let frame = GridFrame {
            origin_m: Point2::new(any(200.0) - 100.0, -any(1e-5)),
            cell_m: 0.001 + any(0.3),
            width: 1 + any(40.0) as usize,
            height: 1 + any(40.0) as usize,
        };
        let all = [Cell::Free, Cell::Occupied, Cell::Unknown];
        let cells = (0..frame.cells()).map(|_| all[any(3.0) as usize]).collect();
        let map = OccupancyMap { frame, cells };
        let stem = folder.path().join(format!("sub/map {k}: v1.2 ü"));
        map.save(&stem).unwrap();
        let again = OccupancyMap::load(&beside(&stem, ".yaml")).unwrap();
        assert_eq!(again, map);
    }
}

#[test]
fn what_is_written_is_what_ros_writes() {
    let folder = tempfile::tempdir().unwrap();
    let frame = GridFrame { origin_m: Point2::new(-1.0, 0.1), cell_m: 0.05, width: 3, height: 1 };
    let cells = vec![Cell::Free, Cell::Occupied, Cell::Unknown];
    OccupancyMap { frame, cells }.save(&folder.path().join("lab")).unwrap();
    let page = fs::read_to_string(folder.path().join("lab.yaml")).unwrap();
    assert_eq!(
        page,
        "image: \"lab.pgm\"\nresolution: 0.05\norigin: [-1.0, 0.1, 0.0]\nnegate: 0\n\
         occupied_thresh: 0.65\nfree_thresh: 0.196\nmode: trinary\n"
    );
    let picture = fs::read(folder.path().join("lab.pgm")).unwrap();
    assert_eq!(picture, b"P5\n# 0.05 m a pixel\n3 1\n255\n\xfe\x00\xcd");
}

#[test]
fn what_cannot_be_used_is_named() {
    let with = |from: &str, to: &str| PAGE.replace(from, to);
    for (page, expected) in [
        (with("resolution: 0.05\n", ""), "resolution"),
        (with("0.05", "five"), "five"),
        (with("0.05", "0"), "resolution = 0: is out of range; use a number from"),
        (with("0.05", ".nan"), "resolution = NaN: is not a number"),
        (with("-10.0, 2.5, 0.0", "-10.0, 2.5"), "origin = [-10.0, 2.5]: has not three numbers"),
        (with("-10.0, 2.5, 0.0", ".inf, 2.5, 0.0"), "origin[0] = inf: is out of range"),
        (with("2.5, 0.0", "2.5, 0.1"), "origin[2] = 0.1: turns the map; turn the picture"),
        (with("2.5, 0.0", "2.5, .nan"), "origin[2] = NaN"),
        (with("negate: 0", "negate: 2"), "negate = 2: is neither 0 nor 1"),
        (with("0.65", "1.65"), "occupied_thresh = 1.65: is out of range"),
        (with("0.196", "0.7"), "free_thresh = 0.7: is above occupied_thresh, 0.65"),
        (format!("{PAGE}mode: raw\n"), "mode = raw: is not read here"),
        (with("map.pgm", "none.pgm"), "image = none.pgm: "),
        (with("map.pgm", "map.yaml"), "map.yaml: first two bytes = im: are not those of PGM"),
        ("[1, 2".to_owned(), "a map's page is YAML with image"),
        (String::new(), "a map's page is YAML with image"),
        ("x".repeat(70_000), "longer than 65536 bytes"),
    ] {
        let error = load(&page).unwrap_err().to_string();
        assert!(error.contains(expected) && error.contains("map.yaml"), "{error}, not {expected}");
    }
    let nowhere = OccupancyMap::load(Path::new("/nowhere/map.yaml")).unwrap_err();
    assert!(nowhere.to_string().starts_with("/nowhere/map.yaml: No such file"), "{nowhere}");
    let map = load(PAGE).unwrap();
    let error = map.save(Path::new("/")).unwrap_err().to_string();
    assert!(error.contains("stem = /: cannot be named"), "{error}");
}

#[test]
fn a_real_map_is_read() {
    let beside = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data/turtlebot3-map.yaml");
    let path = Path::new(beside);
    if !path.exists() {
        println!("skipped: {} is not on this machine", path.display());
        return;
    }
    let map = OccupancyMap::load(path).unwrap();
    let count = |wanted| map.cells.iter().filter(|cell| **cell == wanted).count();
    let found = [Cell::Free, Cell::Occupied, Cell::Unknown].map(count);
    assert_eq!((map.frame.width, map.frame.height), (384, 384));
    assert_eq!(map.frame.origin_m, Point2::new(-10.0, -10.0));
    // As counted in the file's bytes 254, 0 and 205.
    assert_eq!(found, [7939, 795, 138_722]);
    assert_eq!(map.at(Point2::new(-2.0, -0.5)), Cell::Free);
}
