//! The golden runs: their digests are constants, the table leaves nothing out,
//! and every entry would notice a change.
#![allow(clippy::unwrap_used, reason = "part of tests, though not of test functions")]

use std::collections::BTreeSet;
use std::f64::consts::FRAC_PI_2;

use rusty_contract::{
    Frame, Kidnapping, LidarConfig, OwnedReadings, RobotConfig, RunConfig, ScriptConfig, Sensors,
};
use rusty_geometry::{Material, PLACES, SE2};
use rusty_sim::golden::{GOLDENS, Golden, digest_of, driver_command};
use rusty_sim::{Sim, StepOutcome};
use serde_json::Value;

#[test]
fn every_golden_has_the_digest_it_always_had() {
    let wrong: Vec<String> = GOLDENS
        .iter()
        .map(|golden| (golden, golden.found().unwrap()))
        .filter(|(golden, found)| golden.expected != found)
        .map(|(golden, found)| format!("{}: {found}, not {}", golden.name, golden.expected))
        .collect();
    assert!(wrong.is_empty(), "other bits than ever:\n{}", wrong.join("\n"));
}

/// Prints the table as it comes out now.
#[test]
#[ignore = "prints new digests after a change of bits that is meant"]
fn mint() {
    for golden in &GOLDENS {
        println!("{:20} {}", golden.name, golden.found().unwrap());
    }
}

fn golden(name: &str) -> &'static Golden {
    static TABLE: [Golden; GOLDENS.len()] = GOLDENS;
    TABLE.iter().find(|golden| golden.name == name).unwrap()
}

fn digest(config: RunConfig) -> [u8; 16] {
    digest_of(config).unwrap().world()
}

/// The kinds of script there are, from the one who must know all: the reader
/// of scenarios, when it is given an invalid kind.
fn script_kinds() -> BTreeSet<String> {
    let error = serde_json::from_str::<ScriptConfig>(r#"{ "kind": "none" }"#).unwrap_err();
    let text = error.to_string();
    text.split('`').skip(3).step_by(2).map(str::to_owned).collect()
}

#[test]
fn every_script_place_and_material_is_in_the_table() {
    let scripts: BTreeSet<String> =
        GOLDENS.iter().map(|golden| golden.config().script.kind().to_owned()).collect();
    assert!(scripts.len() >= 6);
    assert_eq!(scripts, script_kinds());

    let worlds: BTreeSet<String> =
        GOLDENS.iter().map(|golden| golden.config().world.name).collect();
    for (place, _) in PLACES {
        assert!(worlds.contains(*place), "no golden run in {place}");
    }
    assert_eq!(worlds.len(), PLACES.len() + 1, "and one world of the table's own: {worlds:?}");

    let own = golden("lopsided").config().world;
    let materials: BTreeSet<usize> = own
        .walls
        .iter()
        .map(|wall| match wall.material {
            Material::Wall => 0,
            Material::Glass => 1,
            Material::Door(_) => 2,
        })
        .collect();
    assert_eq!(materials.len(), 3);
}

/// A change of one thing in a configuration.
type Change = fn(&mut RunConfig);

/// The sources of noise: which fields hold them, and how each is silenced.
const NOISES: [(&str, Change); 10] = [
    ("slip", |c| c.robot.slip_std = 0.0),
    ("radius bias", |c| c.robot.radius_bias_right = 0.0),
    ("range noise", |c| c.lidar.range_std_m = 0.0),
    ("dropout", |c| c.lidar.dropout = 0.0),
    ("relative range noise", |c| c.lidar.range_std_per_m = 0.0),
    ("glass", |c| c.lidar.glass_visible_rad = FRAC_PI_2),
    ("mixed pixels", |c| c.lidar.divergence_rad = 0.0),
    ("slip of the left wheel", |c| c.robot.slip_std_left = None),
    ("outliers", |c| c.robot.slip_outlier_rate = 0.0),
    ("patches", |c| c.patches.clear()),
];

#[test]
fn every_noise_is_in_the_table_and_is_felt() {
    for (noise, silence) in NOISES {
        let mut felt = 0;
        for golden in GOLDENS {
            let mut config = golden.config();
            silence(&mut config);
            let has_it = config != golden.config();
            let of_motion =
                ["slip", "radius bias", "slip of the left wheel", "outliers", "patches"];
            let needs_scans = !of_motion.contains(&noise);
            if has_it && !(needs_scans && config.scan_every == 0) {
                felt += 1;
                let changed = digest(config) != digest(golden.config());
                assert!(changed, "{} does not feel its {noise}", golden.name);
            }
        }
        assert!(felt > 0, "no golden run has {noise}");
    }
}

/// Every number of a document, by the path to it.
fn numbers(value: &Value, path: &str, found: &mut Vec<String>) {
    match value {
        Value::Number(_) => found.push(path.to_owned()),
        Value::Array(list) => {
            for (i, one) in list.iter().enumerate().take(1) {
                numbers(one, &format!("{path}/{i}"), found);
            }
        }
        Value::Object(map) => {
            map.iter().for_each(|(key, one)| numbers(one, &format!("{path}/{key}"), found));
        }
        _ => {}
    }
}

#[test]
fn every_number_of_every_small_sensor_is_felt() {
    let golden = golden("apartment-sensed").config();
    let whole = serde_json::to_value(&golden.sensors).unwrap();
    let mut paths = Vec::new();
    numbers(&whole, "", &mut paths);
    assert!(paths.len() > 25, "{paths:?}");
    for path in paths {
        let mut changed = whole.clone();
        let place = changed.pointer_mut(&path).unwrap();
        *place = match place.as_u64() {
            Some(whole) => (whole + 2).into(),
            None => (0.7 * place.as_f64().unwrap() + 0.01).into(),
        };
        let mut config = golden.clone();
        config.sensors = serde_json::from_value(changed).unwrap();
        assert_ne!(digest(config), digest(golden.clone()), "{path} is not felt");
    }
}

#[test]
fn every_small_sensor_is_in_the_table_and_changes_no_other_noise() {
    let golden = golden("apartment-sensed").config();
    let Sensors { bumper, imu, sonar, doors, landmarks } = golden.sensors.clone();
    assert!(bumper.is_some() && imu.is_some() && sonar.is_some());
    assert!(doors.is_some() && landmarks.is_some());
    let run = |config: RunConfig| {
        let mut sim = Sim::new(config.clone()).unwrap();
        let mut frame = Frame::boxed();
        (0..config.ticks)
            .map(|_| {
                let _ = sim.step(None, &mut frame);
                (frame.encoders(), frame.ranges_m().map(<[f64]>::to_vec), frame.readings().into())
            })
            .collect::<Vec<(_, _, OwnedReadings)>>()
    };
    let all = run(golden.clone());
    let without: [fn(&mut Sensors); 5] = [
        |s| s.bumper = None,
        |s| s.imu = None,
        |s| s.sonar = None,
        |s| s.doors = None,
        |s| s.landmarks = None,
    ];
    for remove in without {
        let mut config = golden.clone();
        remove(&mut config.sensors);
        for (tick, (a, b)) in all.iter().zip(run(config)).enumerate() {
            assert_eq!((a.0, &a.1), (b.0, &b.1), "tick {tick}");
            let (a, b) = (a.2.get(), b.2.get());
            let kept: Vec<_> = b.named().collect();
            let before: Vec<_> = a.named().filter(|one| kept.contains(one)).collect();
            assert_eq!(kept, before, "tick {tick}");
        }
    }
}

/// One change for every number of a configuration. Taken apart without a rest:
/// a new field does not compile until it stands here, with its change below.
#[allow(clippy::too_many_lines, reason = "a table")]
fn changes(config: &RunConfig) -> Vec<(&'static str, Change)> {
    let RunConfig {
        scenario: _, // a name
        seed: _,
        ticks: _,
        dt_s: _,
        scan_every: _,
        start: _,
        robot,
        lidar,
        script: _,  // "every script" above
        world: _,   // a corner of it
        sensors: _, // every number of them below
        // Felt in tests of `sim`, `people` and `events`.
        kidnappings: _,
        walkers: _,
        crowd: _,
        fleet: _,
        events: _,
        patches: _,
    } = config;
    let RobotConfig {
        wheel_radius_m: _,
        track_m: _,
        body_radius_m: _,
        ticks_per_rev: _,
        wheel_limit_rad_s: _,
        slip_std: _,
        slip_std_left: _,
        slip_std_right: _,
        slip_outlier_rate: _,
        slip_outlier_factor: _,
        radius_bias_right: _,
        track_bias: _,
    } = robot;
    let mut changes = lidar_changes(lidar);
    changes.extend::<[(_, Change); _]>([
        ("seed", |c| c.seed ^= 1),
        ("ticks", |c| c.ticks -= 1),
        ("dt_s", |c| next(&mut c.dt_s)),
        ("scan_every", |c| c.scan_every += 1),
        ("start", |c| next_pose(&mut c.start)),
        ("kidnappings", |c| {
            let mut to = c.start;
            next_pose(&mut to);
            c.kidnappings.push(Kidnapping { tick: 0, to });
        }),
        ("wheel_radius_m", |c| next(&mut c.robot.wheel_radius_m)),
        ("track_m", |c| next(&mut c.robot.track_m)),
        // Felt where the body touches: some tick is blocked, or is not.
        ("body_radius_m", |c| c.robot.body_radius_m *= 1.5),
        ("ticks_per_rev", |c| c.robot.ticks_per_rev += 1),
        ("wheel_limit_rad_s", |c| next(&mut c.robot.wheel_limit_rad_s)),
        // They are added to one, where their own last bits are lost.
        ("slip_std", |c| c.robot.slip_std += 1e-13),
        ("slip_std_left", |c| c.robot.slip_std_left = Some(0.07)),
        ("slip_std_right", |c| c.robot.slip_std_right = Some(0.07)),
        ("slip_outlier_rate", |c| c.robot.slip_outlier_rate += 0.3),
        ("slip_outlier_factor", |c| c.robot.slip_outlier_factor += 1e-11),
        ("patches", |c| c.patches.truncate(1)),
        ("patch.corners", |c| c.patches[1].corners[0][0] += 0.3),
        ("patch.slip_std", |c| c.patches[1].slip_std += 1e-13),
        ("patch.slip_outlier_rate", |c| c.patches[1].slip_outlier_rate += 0.3),
        ("patch.slip_outlier_factor", |c| c.patches[1].slip_outlier_factor += 1e-11),
        ("radius_bias_right", |c| c.robot.radius_bias_right += 1e-13),
        ("track_bias", |c| c.robot.track_bias += 1e-13),
        ("a corner", |c| next(&mut c.world.walls[0].a[0])),
    ]);
    changes
}

/// The changes of the LiDAR's numbers.
fn lidar_changes(lidar: &LidarConfig) -> Vec<(&'static str, Change)> {
    let LidarConfig {
        beams: _,
        first_bearing_rad: _,
        fov_rad: _,
        range_max_m: _,
        range_std_m: _,
        range_std_per_m: _,
        dropout: _,
        glass_visible_rad: _,
        divergence_rad: _,
        sensor_in_body: _,
    } = lidar;
    vec![
        ("beams", |c| c.lidar.beams += 1),
        ("first_bearing_rad", |c| next(&mut c.lidar.first_bearing_rad)),
        ("fov_rad", |c| next(&mut c.lidar.fov_rad)),
        ("range_max_m", |c| next(&mut c.lidar.range_max_m)),
        ("range_std_m", |c| next(&mut c.lidar.range_std_m)),
        ("range_std_per_m", |c| c.lidar.range_std_per_m = 1e-6),
        ("dropout", |c| c.lidar.dropout += 0.01),
        ("glass_visible_rad", |c| c.lidar.glass_visible_rad = 0.2),
        ("divergence_rad", |c| c.lidar.divergence_rad = 0.05),
        ("sensor_in_body", |c| next_pose(&mut c.lidar.sensor_in_body)),
    ]
}

/// The next number there is: one bit.
fn next(value: &mut f64) {
    *value = value.next_up();
}

/// A pose whose x is the next number there is.
fn next_pose(pose: &mut SE2) {
    *pose = SE2::new(pose.x().next_up(), pose.y(), pose.theta());
}

/// Asserts that a run feels the changes of the fields that `is_felt` selects.
fn assert_feels(name: &str, is_felt: impl Fn(&str) -> bool) {
    let config = golden(name).config();
    let before = digest(config.clone());
    for (field, change) in changes(&config).into_iter().filter(|(field, _)| is_felt(field)) {
        let mut changed = config.clone();
        change(&mut changed);
        assert_ne!(changed, config, "{field} was not changed");
        assert_ne!(digest(changed), before, "{name}: {field} is not felt");
    }
}

#[test]
fn every_number_is_felt() {
    let of_patches = |field: &str| field.starts_with("patch") || field == "slip_outlier_factor";
    // The LiDAR of the lopsided run looks away from its pane.
    assert_feels("lopsided", |field| field != "glass_visible_rad" && !of_patches(field));
    assert_feels("apartment-slippery", |field| of_patches(field) || field.starts_with("slip"));
    assert_feels("lobby-glass", |field| {
        ["range_std_per_m", "glass_visible_rad", "divergence_rad"].contains(&field)
    });
}

#[test]
fn every_golden_feels_its_seed_and_the_last_bit_of_its_start() {
    for golden in GOLDENS {
        let before = digest(golden.config());
        let mut moved = golden.config();
        next_pose(&mut moved.start);
        assert_ne!(digest(moved), before, "{}: start", golden.name);

        let mut seeded = golden.config();
        seeded.seed = seeded.seed.wrapping_add(1);
        let silent = golden.name == "apartment-silent";
        assert_eq!(digest(seeded) == before, silent, "{}: seed", golden.name);
    }
    let distinct: BTreeSet<&str> = GOLDENS.iter().map(|golden| golden.expected).collect();
    assert_eq!(distinct.len(), GOLDENS.len());
}

/// What happens in a golden run.
#[derive(Default)]
struct Happened {
    moved: u64,
    blocked: u64,
    /// Ticks in which the driver wanted more than wheels can do.
    limited: u64,
    ranges_m: Vec<f64>,
}

fn watch(name: &str) -> Happened {
    let mut sim = Sim::new(golden(name).config()).unwrap();
    let mut frame = Frame::boxed();
    let mut happened = Happened::default();
    for tick in 0..sim.config().ticks {
        match sim.step(Some(driver_command(tick)), &mut frame) {
            StepOutcome::Moved { .. } => happened.moved += 1,
            StepOutcome::Blocked => happened.blocked += 1,
        }
        happened.limited += u64::from(frame.command() != driver_command(tick));
        happened.ranges_m.extend(frame.ranges_m().into_iter().flatten());
    }
    happened
}

#[test]
fn what_the_texts_say_does_happen() {
    let run = watch("apartment-blocked");
    assert!(run.moved > 5 && run.blocked > 5, "{} and {}", run.moved, run.blocked);

    let run = watch("hallway-commands");
    let share = |m: f64| {
        let there = run.ranges_m.iter().filter(|range_m| **range_m == m).count();
        there as f64 / run.ranges_m.len() as f64
    };
    assert!(share(0.0) > 0.1 && share(3.0) > 0.1, "{} and {}", share(0.0), share(3.0));

    let run = watch("lopsided");
    let counts = (run.limited, run.moved, run.blocked);
    assert!(counts.0 > 20 && counts.1 > 100 && counts.2 > 0, "{counts:?}");
    assert!(run.ranges_m.contains(&3.7), "nothing dropped out");

    let run = watch("hallway-patrol");
    assert_eq!((run.moved, run.blocked), (150, 0));
}
