//! Sonars against dense sampling, and what each model hears.

use super::*;
use rusty_geometry::{Material, WallSpec, WorldSpec, apartment};

fn sonar(model: SonarModel, aperture_rad: f64, world: &World) -> Sonars {
    let config = SonarConfig { model, aperture_rad, ..SonarConfig::default() };
    Sonars::new(&config, world, 1)
}

fn room() -> World {
    let corners = [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]];
    let wall =
        |k: usize| WallSpec { a: corners[k], b: corners[(k + 1) % 4], material: Material::Wall };
    World::new(WorldSpec {
        name: "room".to_owned(),
        bounds: [0.0, 0.0, 4.0, 3.0],
        walls: (0..4).map(wall).collect(),
        landmarks: Vec::new(),
    })
    .unwrap()
}

/// Poses of sensors in the apartment that are clear of its walls.
fn poses() -> impl Iterator<Item = SE2> {
    let world = apartment();
    let [x_min, y_min, x_max, y_max] = world.bounds();
    (0..400u32).filter_map(move |k| {
        // A lattice that repeats nowhere (R2 sequence, M. Roberts 2018).
        let (u, v) = (f64::from(k) * 0.754_877_666 % 1.0, f64::from(k) * 0.569_840_291 % 1.0);
        let (x, y) = (x_min + u * (x_max - x_min), y_min + v * (y_max - y_min));
        let clear = world.distance_to_nearest(Point2::new(x, y)) > 0.05;
        clear.then(|| SE2::new(x, y, f64::from(k) * 2.4 % 6.0))
    })
}

#[test]
fn the_nearest_point_of_the_cone_is_the_least_of_many_rays() {
    let world = apartment();
    for (i, pose) in poses().enumerate() {
        let aperture_rad = [0.26, 0.52, 1.5, std::f64::consts::PI][i % 4];
        let exact_m = sonar(SonarModel::Nearest, aperture_rad, &world).exact_m(&world, &pose);
        let rays = 20_000;
        let angle = |k: u32| pose.theta() + aperture_rad * (f64::from(k) / f64::from(rays) - 0.5);
        let origin = Point2::from(pose.translation());
        let ray_m = |k| world.raycast(origin, angle(k), 10.7).distance_m;
        let sampled_m = (0..=rays).map(ray_m).fold(10.7, f64::min);
        assert!(exact_m <= sampled_m + 1e-9, "pose {i}: {exact_m} {sampled_m}");
        // Between two rays a wall can be nearer by what a grazing angle hides.
        assert!(exact_m >= sampled_m - 1e-2, "pose {i}: {exact_m} {sampled_m}");
    }
}

#[test]
fn a_flat_wall_is_heard_as_an_arc_of_constant_depth() {
    let world = room();
    let at = |degrees: f64| SE2::new(2.0, 1.0, -std::f64::consts::FRAC_PI_2 + degrees.to_radians());
    for model in [SonarModel::Nearest, SonarModel::Specular] {
        let sonar = sonar(model, 30f64.to_radians(), &world);
        for degrees in [-14.0, -5.0, 0.0, 14.0] {
            let range_m = sonar.exact_m(&world, &at(degrees));
            assert!((range_m - 1.0).abs() < 1e-12, "{model:?} at {degrees}°: {range_m}");
        }
    }
    // Beyond the half angle the perpendicular is out of the cone: the nearest point
    // moves along the wall, and a mirror does not answer.
    let nearest_m =
        sonar(SonarModel::Nearest, 30f64.to_radians(), &world).exact_m(&world, &at(25.0));
    assert!((nearest_m - 1.0 / trig::cos(10f64.to_radians())).abs() < 1e-12, "{nearest_m}");
    let mirror_m =
        sonar(SonarModel::Specular, 30f64.to_radians(), &world).exact_m(&world, &at(25.0));
    assert_eq!(mirror_m, 10.7);
}

#[test]
fn a_corner_answers_from_between_its_walls_only() {
    let world = room();
    let sonar = sonar(SonarModel::Specular, 30f64.to_radians(), &world);
    assert_eq!(sonar.corners.len(), 4);
    let towards = |x: f64, y: f64| SE2::new(x, y, trig::atan2(-y, -x));
    let range_m = sonar.exact_m(&world, &towards(1.5, 1.2));
    assert!((range_m - trig::hypot(1.5, 1.2)).abs() < 1e-12, "{range_m}");
    // From outside, the same corner is an edge.
    assert_eq!(sonar.exact_m(&world, &towards(-1.5, -1.2)), 10.7);
}

#[test]
fn an_end_on_the_middle_of_a_wall_makes_two_corners() {
    let wall = |a, b| Wall { a: Point2::from(a), b: Point2::from(b), material: Material::Wall };
    let corners = |walls: &[Wall]| corners(&room().with_walls(walls.to_vec()));
    let through = wall([0.0, 0.0], [4.0, 0.0]);
    let stem = wall([2.0, 0.0], [2.0, 1.0]);
    let found = corners(&[through, stem]);
    assert_eq!(found.len(), 2);
    let facing = |x| found.iter().filter(|c| c.faces(&Point2::new(x, 0.5))).count();
    assert_eq!((facing(1.0), facing(3.0)), (1, 1));
    assert!(corners(&[through, wall([4.0, 0.0], [6.0, 0.1])]).is_empty(), "nearly straight");
}

#[test]
fn what_stands_before_an_echo_hides_it() {
    let mut spec = room().spec().clone();
    // A screen that is aslant, so that it does not answer itself.
    let screen = WallSpec { a: [1.9, 0.6], b: [2.1, 0.4], material: Material::Wall };
    spec.walls.push(screen);
    let world = World::new(spec).unwrap();
    let down = SE2::new(2.0, 1.0, -std::f64::consts::FRAC_PI_2);
    let hidden = sonar(SonarModel::Specular, 0.1, &world).exact_m(&world, &down);
    assert_eq!(hidden, 10.7);
    let heard = sonar(SonarModel::Nearest, 0.1, &world).exact_m(&world, &down);
    assert!((heard - 0.5).abs() < 0.06, "{heard}");
}

#[test]
fn a_mirror_hears_no_one_behind_a_wall_or_off_its_axis() {
    let mut spec = room().spec().clone();
    spec.walls.push(WallSpec { a: [1.9, 0.6], b: [2.1, 0.4], material: Material::Wall });
    let screened = World::new(spec).unwrap();
    let down = SE2::new(2.0, 1.0, -std::f64::consts::FRAC_PI_2);
    let person = |x: f64| [Disc { centre: Point2::new(x, 0.3), radius_m: 0.1 }];
    let heard_m = |model, world: &World, x| {
        let sonar = sonar(model, 0.2, world);
        sonar.exact_m(Scene { world, bodies: &person(x) }, &down)
    };
    let open = room();
    assert!((heard_m(SonarModel::Specular, &open, 2.0) - 0.6).abs() < 1e-12);
    assert_eq!(heard_m(SonarModel::Specular, &screened, 2.0), 10.7);
    // With its middle outside the cone, a rim is in it: a mirror hears the wall behind.
    assert!((heard_m(SonarModel::Specular, &open, 2.15) - 1.0).abs() < 1e-12);
    let rim_m = heard_m(SonarModel::Nearest, &open, 2.15);
    assert!((0.6..0.8).contains(&rim_m), "{rim_m}");
}

#[test]
fn noise_and_dropout_have_their_size() {
    let world = room();
    let config =
        SonarConfig { dropout: 0.2, range_std_m: 0.03, every: 1, ..SonarConfig::default() };
    let mut sonars = Sonars::new(&config, &world, 9);
    let pose = SE2::new(2.0, 1.5, 0.0);
    let (mut sum, mut heard) = (0.0, 0.0);
    let ticks = 10_000;
    for tick in 0..ticks {
        let range_m = sonars.read(&world, &pose, tick).unwrap()[0];
        if range_m < 10.7 {
            // Mounted 10 cm ahead of the centre, 1.9 m from the wall x = 4.
            let z = (range_m - 1.9) / 0.03;
            sum += z * z;
            heard += 1.0;
        }
    }
    assert!((heard / ticks as f64 - 0.8).abs() < 0.01, "{heard}");
    assert!((sum / heard - 1.0).abs() < 0.05, "{}", sum / heard);
}
