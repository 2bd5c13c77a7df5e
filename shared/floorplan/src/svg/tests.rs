//! Drawings of one room in many ways; materials, scales, and what cannot be used.

use rusty_geometry::World;

use super::*;

const CM: &str = "viewBox=\"0 0 400 300\" width=\"400cm\" height=\"300cm\"";

fn read(root: &str, inside: &str) -> Result<WorldSpec, FieldError> {
    walls(&format!("<svg xmlns=\"http://www.w3.org/2000/svg\" {root}>{inside}</svg>"), "plan")
}

fn world(inside: &str) -> WorldSpec {
    let spec = read(CM, inside).unwrap_or_else(|e| panic!("{inside}: {e}"));
    assert_eq!(spec.check(), Ok(()), "{inside}");
    spec
}

/// The walls, each from its lesser end, sorted.
fn ends(spec: &WorldSpec) -> Vec<[[f64; 2]; 2]> {
    let order = |p: &[f64; 2], q: &[f64; 2]| p.partial_cmp(q).unwrap();
    let mut walls: Vec<[[f64; 2]; 2]> = spec.walls.iter().map(|w| [w.a, w.b]).collect();
    walls.iter_mut().for_each(|wall| wall.sort_by(order));
    walls.sort_by(|p, q| p.partial_cmp(q).unwrap());
    walls
}

#[test]
fn every_shape_draws_the_same_room() {
    // From 10 cm to 410 cm would be beyond the drawing: this is 1 m by 0.5 m.
    let corners = [[0.1, 2.3], [0.1, 2.8], [1.1, 2.3], [1.1, 2.8]];
    let [a, b, c, d] = corners;
    let expected = [[a, b], [a, c], [b, d], [c, d]];
    let line =
        |x1, y1, x2, y2| format!("<line x1='{x1}' y1='{y1}' x2='{x2}' y2='{y2}' stroke='black'/>");
    let lines = [[10, 20, 110, 20], [110, 20, 110, 70], [110, 70, 10, 70], [10, 70, 10, 20]]
        .map(|[x1, y1, x2, y2]| line(x1, y1, x2, y2));
    let style = "fill='none' stroke='#333'";
    for drawing in [
        format!("<rect x='10' y='20' width='100' height='50' {style}/>"),
        "<rect x='10' y='20' width='100' height='50'/>".to_owned(),
        format!("<polygon points='10,20 110,20 110,70 10,70' {style}/>"),
        format!("<polyline points='10,20 110,20 110,70 10,70 10,20' {style}/>"),
        format!("<path d='M10 20 H110 V70 H10 Z' {style}/>"),
        format!("<path d='m10,20 h100 v50 l-100,0 z' {style}/>"),
        format!("<path d='M10 20 L110 20 110 70 M110 70 L10 70 10 20' {style}/>"),
        lines.concat(),
        format!("<g transform='translate(10 20) scale(2)'><rect width='50' height='25' {style}/></g>"),
        format!("<g transform='translate(110 20) rotate(90)'><path d='M0 0H50V100H0Z' {style}/></g>"),
        format!("<defs><rect id='r' width='100' height='50' {style}/></defs><use href='#r' x='10' y='20'/>"),
        format!("<svg x='10' y='20'><rect width='100' height='50' {style}/></svg>"),
        "<style>.w{stroke:red;fill:none}</style><rect class='w' x='10' y='20' width='100' height='50'/>"
            .to_owned(),
    ] {
        assert_eq!(ends(&world(&drawing)), expected, "{drawing}");
    }
    let bounds = world(&lines.concat()).bounds;
    assert_eq!(bounds.map(|v| (v * 1e6).round() / 1e6), [0.0, 2.2, 1.2, 2.9]);
}

#[test]
fn curves_stay_within_their_tolerance() {
    for circle in [
        "<circle cx='200' cy='150' r='100' stroke='black'/>",
        "<path d='M100 150A100 100 0 0 1 300 150a100 100 0 0 1 -200 0z' stroke='black'/>",
    ] {
        let spec = world(circle);
        assert!((40..400).contains(&spec.walls.len()), "{}", spec.walls.len());
        for wall in &spec.walls {
            let from_centre =
                |[x, y]: [f64; 2]| ((x - 2.0) * (x - 2.0) + (y - 1.5) * (y - 1.5)).sqrt();
            let middle = [0, 1].map(|k| 0.5 * (wall.a[k] + wall.b[k]));
            // Four cubics are a circle to 0.03 %.
            assert!((from_centre(wall.a) - 1.0).abs() < 3.1e-4, "{wall:?}");
            assert!((from_centre(middle) - 1.0).abs() < CURVE_TOLERANCE_M + 3.1e-4, "{wall:?}");
        }
        // Closed: a beam from the centre ends everywhere.
        let world = World::new(spec).unwrap();
        let hit = |k: i32| world.raycast([2.0, 1.5].into(), 0.01 * f64::from(k), 9.0).material;
        assert!((0..629).all(|k| hit(k).is_some()));
    }
    let quadratic = world("<path d='M0 100 Q 200 300 400 100' fill='none' stroke='black'/>");
    let top = quadratic.walls.iter().map(|wall| wall.a[1]).fold(f64::MAX, f64::min);
    assert!((top - 1.0).abs() < 1e-3, "the curve reaches half of the way to its control: {top}");
}

#[test]
fn materials_are_named_by_colour_class_and_id() {
    let one = |inside: &str| world(inside).walls[0].material;
    let line = |more: &str| format!("<path d='M0 0H100' {more}/>");
    for (attributes, material) in [
        ("stroke='black'", Material::Wall),
        ("stroke='#8800ff'", Material::Wall),
        ("stroke='aqua'", Material::Glass),
        ("style='stroke:#0ff'", Material::Glass),
        ("stroke='red'", Material::Door(0)),
        ("stroke='#ff0003'", Material::Door(3)),
        ("class='glass'", Material::Glass),
        ("class='thick glass' stroke='black'", Material::Glass),
        ("class='glass' style='stroke:black'", Material::Glass),
        ("class='wall' stroke='red'", Material::Wall),
        ("id='door-3'", Material::Door(3)),
        ("class='door' stroke='black'", Material::Door(0)),
        ("class='door-255' stroke='black'", Material::Door(255)),
        ("class='door-mat' stroke='black'", Material::Wall),
    ] {
        assert_eq!(one(&line(attributes)), material, "{attributes}");
        let group = format!("<g {attributes}><g>{}</g></g>", line(""));
        assert_eq!(one(&group), material, "in a group: {attributes}");
    }
    let inner = format!("<g class='glass'>{}</g>", line("class='door-7'"));
    assert_eq!(one(&inner), Material::Door(7));
    let error = read(CM, &line("class='door-256'")).unwrap_err().to_string();
    assert!(error.contains("class = door-256") && error.contains("0 to 255"), "{error}");
}

#[test]
fn what_is_not_seen_is_not_a_wall() {
    let wall = "<path d='M0 0H100' stroke='black'/>";
    for unseen in [
        "<path d='M0 50H100' fill='none'/>",
        "<rect width='400' height='300' fill='white'/>",
        "<g display='none'><path d='M0 50H100' stroke='black'/></g>",
        "<path d='M0 50H100' stroke='black' visibility='hidden'/>",
        "<text x='10' y='50'>kitchen</text>",
        "<image href='/dev/zero' width='10' height='10'/>",
        "<defs><path d='M0 50H100' stroke='black'/></defs>",
    ] {
        assert_eq!(world(&format!("{wall}{unseen}")).walls.len(), 1, "{unseen}");
    }
}

#[test]
fn an_end_on_a_slanted_line_is_joined_to_it() {
    // (123.4, 87.91…) lies on the first line; five digits put the end 3 µm off.
    let first = "<path d='M11 7 L391 280' stroke='black'/>";
    let second = "<path d='M123.4 87.751 V290' stroke='black'/>";
    let spec = world(&format!("{first}{second}"));
    assert_eq!(spec.walls.len(), 3, "{:?}", spec.walls);
    assert_eq!(spec.walls[0].b, spec.walls[1].a);
}

#[test]
fn the_scale_is_the_size_or_is_given() {
    let wall = "<path d='M0 300H400' stroke='black'/>";
    let length = |root: &str| read(root, wall).map(|spec| spec.walls[0].b[0] - spec.walls[0].a[0]);
    let view = "viewBox='0 0 400 300'";
    for (root, expected) in [
        (CM.to_owned(), 4.0),
        (format!("{view} width='4000mm' height='3000mm'"), 4.0),
        (format!("{view} width='100in' height='75in'"), 2.54),
        (format!("{view} {SCALE}='0.01'"), 4.0),
        (format!("{view} {SCALE}='0.01' width='800' height='600'"), 4.0),
        (format!("viewBox='-50 -20 800 600' {SCALE}='0.02' width='21cm' height='29cm'"), 8.0),
        (format!("{SCALE}='0.02' width='400' height='300'"), 8.0),
    ] {
        assert!((length(&root).unwrap() - expected).abs() < 1e-4, "{root}: {:?}", length(&root));
    }
    // The lower left corner of the view is (0, 0).
    let moved = read("viewBox='-50 0 500 400' data-metres-per-unit='0.01'", wall).unwrap();
    assert_eq!((moved.walls[0].a, moved.walls[0].b), ([0.5, 1.0], [4.5, 1.0]));
    for root in [view, "", "width='400' height='300'", "width='12m' height='9m' viewBox='0 0 4 3'"]
    {
        let error = length(root).unwrap_err().to_string();
        assert!(error.contains("data-metres-per-unit=\"0.01\""), "{root}: {error}");
    }
    for (value, words) in [("1 cm", "is not a number"), ("0", "out of range"), ("nan", "NaN")] {
        let error = length(&format!("{view} {SCALE}='{value}'")).unwrap_err().to_string();
        assert!(error.contains(SCALE) && error.contains(words), "{error}");
    }
}

#[test]
fn what_cannot_be_used_is_named() {
    for text in ["", "name = \"box\"", "<svg", "<html/>"] {
        let error = walls(text, "plan").unwrap_err().to_string();
        assert!(error.starts_with("SVG = "), "{text}: {error}");
    }
    let error = read(CM, "<text>empty</text>").unwrap_err().to_string();
    assert!(error.contains("lines = 0: make no wall"), "{error}");
    let zigzag: String = (0..100_002).map(|k| format!("L{} {} ", k % 400, k % 299)).collect();
    let error = read(CM, &format!("<path d='M0 0{zigzag}' stroke='black'/>")).unwrap_err();
    assert!(error.to_string().contains("make too many walls"), "{error}");
}

#[test]
fn a_drawing_without_end_is_refused() {
    let deep = format!("{}{}", "<g>".repeat(200_000), "</g>".repeat(200_000));
    let mut doubled = "<path id='a0' d='M0 0H100' stroke='black'/>".to_owned();
    for k in 0..30 {
        doubled += &format!("<g id='a{}'><use href='#a{k}'/><use href='#a{k}'/></g>", k + 1);
    }
    for endless in [deep, doubled] {
        let error = read(CM, &endless).unwrap_err().to_string();
        assert!(error.starts_with("SVG = "), "{error}");
    }
}
