//! Drivers that see a laser and wheels and no truth: closed loops in the
//! Apartment that touch no wall.

use nalgebra::Point2;
use rusty_clients::{Filter as _, Tick};
use rusty_contract::{Frame, Scenario, Start, config::ScriptConfig};
use rusty_filters::slam::{Slam, SlamOptions};
use rusty_filters::{Cell, OccupancyMap, explore, goto, wander};
use rusty_geometry::{Twist, apartment};
use rusty_metrics::Held;
use rusty_sim::{Sim, StepOutcome};
use rusty_tests::*;

/// A driver's run in the Apartment with the noise of the tables.
fn header(seed: u64, start: SE2) -> LogHeader {
    let mut config = config_of("apartment", &["lidar.dropout=0.02"]);
    // As in the scenarios of the drivers: what they do not see they run into.
    config.lidar.glass_visible_rad = std::f64::consts::FRAC_PI_2;
    config.script = ScriptConfig::Driver {};
    config.seed = seed;
    config.start = start;
    header_of(config, Scenario::usual_participants())
}

/// Drives for some ticks: how many of them a wall held, by the world itself and
/// by truth and command, which must agree; and the true poses.
fn drive(
    header: &LogHeader,
    ticks: u64,
    mut answer: impl FnMut(&Tick<'_>) -> Twist,
) -> (u64, Vec<SE2>) {
    let mut sim = Sim::new(header.config.clone()).unwrap();
    let mut frame = Frame::boxed();
    let mut held = Held::of(header).unwrap();
    let (mut command, mut blocked, mut truths) = (None, 0, Vec::new());
    for tick in 0..ticks {
        blocked += u64::from(sim.step(command, &mut frame) == StepOutcome::Blocked);
        held.push(tick, Some(sim.truth()), frame.command());
        truths.push(sim.truth());
        command = Some(answer(&Tick::detached(&frame)));
    }
    assert_eq!(held.tick_count(), blocked, "truth and command say something else than the world");
    (blocked, truths)
}

fn told(header: &LogHeader) -> Start {
    Start::new(header, 0, &header.roster[0])
}

/// The run ends by itself, well, where its driver is done; its log is a whole one.
#[test]
fn a_driver_that_has_arrived_ends_the_run_and_the_log_repeats_it() {
    let place = folder();
    let scenario = place.write(
        "goto.toml",
        "name = \"arrives\"\nticks = 5000\nscript = { kind = \"driver\" }\n\
         [[participant]]\nname = \"goto\"\nrole = \"driver\"\n\
         command = [\"goto\", \"--waypoint\", \"6.8,4.5\", \"--end\"]\n\
         [[participant]]\nname = \"dead-reckoning\"\ncommand = [\"dead-reckoning\"]\n\
         [[participant]]\nname = \"logger\"\nrole = \"logger\"\ncommand = [\"logger\"]\n",
    );
    let report = launch("arrives", &place.at("out"), &[&scenario]);
    let ticks = report["ticks"].as_u64().unwrap();
    assert_eq!(report["ended"], "done");
    assert!((50..2000).contains(&ticks) && report["ticks_planned"] == 5000, "{ticks}");
    assert_eq!(launch("again", &place.at("again"), &[&scenario])["digest"], report["digest"]);
    let log = place.at("out/run.log");
    let read = Log::read(&log);
    assert!(read.is_complete() && read.records().len() as u64 == ticks);
    about("verify", &log, &["--clients"]).expect(0);
    // It was there before it knew, and never at a second goal.
    let scored = place.at("scored");
    let (log, out) = (arg(&log).to_owned(), arg(&scored).to_owned());
    let score = |goals: &[&str]| {
        let args = ["score", "--log", &log, "--out", &out, "--force"];
        let ended = sim_server(&[&args[..], goals].concat()).expect(0);
        let text = fs::read_to_string(scored.join("score.json")).unwrap();
        (ended.stdout, serde_json::from_str::<Value>(&text).unwrap()["goals"].clone())
    };
    let (printed, goals) = score(&["--goal", "6.8,4.5"]);
    let after_s = goals["after_s"].as_f64().unwrap();
    assert!(after_s > 1.0 && after_s < ticks as f64 * 0.02, "{goals}");
    assert!(printed.contains("goals    1 of 1 reached after "), "{printed}");
    let (_, goals) = score(&["--goal", "6.8,4.5", "--goal", "9.6,4.5"]);
    assert_eq!(goals, json!({ "goals": 2, "reached": 1, "after_s": null, "driven_m": null }));
    assert_eq!(score(&[]).1, Value::Null);
    let log = Path::new(&log);
    let replayed = replay(log, &place.at("replayed"), &[]).expect(0).json();
    assert_eq!((&replayed["digest"], &replayed["ticks"]), (&report["digest"], &report["ticks"]));
}

/// How many seeds a loop in this process runs; more on request.
pub(crate) fn seeds(few: u64) -> u64 {
    std::env::var("RUSTY_SEEDS").ok().and_then(|n| n.parse().ok()).unwrap_or(few)
}

#[test]
fn who_drives_blindly_is_held_as_often_as_the_world_says() {
    let mut all = 0;
    for seed in 0..5 {
        let header = header(seed, SE2::new(9.6, 3.0, 0.3 * seed as f64));
        let mut tick = 0;
        let (blocked, _) = drive(&header, 1500, |_| {
            tick += 1;
            let turns = tick % 400 > 330;
            Twist { v_m_s: 0.6, omega_rad_s: if turns { 1.2 } else { 0.0 } }
        });
        all += blocked;
    }
    assert!(all > 300, "{all}");
}

#[test]
fn a_wanderer_touches_nothing_and_gets_about() {
    let mut rooms = 0;
    for seed in 0..seeds(2) {
        let header = header(seed, SE2::new(6.0, 4.5, 0.0));
        let options = wander::Options { seed, ..Default::default() };
        let told = Start { map: None, initial_pose: None, ..told(&header) };
        let mut wanderer = wander::driver(&told, options);
        let (blocked, truths) =
            drive(&header, 6000, |tick| wanderer.update(tick).command().unwrap());
        assert_eq!(blocked, 0, "seed {seed}");
        let way_m: f64 =
            truths.windows(2).map(|p| (p[1].translation() - p[0].translation()).norm()).sum();
        let seen = visited(&truths, 1.2).iter().filter(|seen| **seen).count();
        println!("seed {seed}: {way_m:.1} m, {seen} rooms");
        assert!(way_m > 20.0, "seed {seed}: {way_m} m in two minutes");
        rooms += seen;
    }
    assert!(rooms >= 2, "{rooms}");
}

/// Which rooms the robot was in, this near to their middles.
fn visited(truths: &[SE2], within_m: f64) -> [bool; 5] {
    let middles = [(5.4, 7.0), (1.8, 7.0), (1.3, 2.0), (4.9, 2.0), (9.6, 4.5)];
    middles.map(|(x, y)| {
        let near = |t: &SE2| (Point2::from(t.translation()) - Point2::new(x, y)).norm() < within_m;
        truths.iter().any(near)
    })
}

/// Tours on seeds from 0 on: all five rooms, the way back, and no wall.
fn tour(seeds: u64, radius_bias_right: f64) {
    for seed in 0..seeds {
        let mut header = header(seed, SE2::new(6.0, 4.5, 0.0));
        header.config.robot.radius_bias_right = radius_bias_right;
        let told = told(&header);
        let mut tour = goto::driver(&told, goto::Options::default()).unwrap();
        let (blocked, truths) = drive(&header, 4200, |tick| tour.update(tick).command().unwrap());
        let tour = tour.task;
        let (rooms, done_at) = (visited(&truths, 0.3), tour.done_at());
        println!("seed {seed}: blocked {blocked}, {rooms:?}, {done_at:?}");
        assert_eq!((blocked, rooms), (0, [true; 5]), "seed {seed}");
        assert!(tour.reached() == 6 && done_at.is_some(), "seed {seed}: {}", tour.reached());
        let home_m =
            (truths[truths.len() - 1].translation() - header.config.start.translation()).norm();
        assert!(home_m < 0.3, "seed {seed}: {home_m} m from home");
    }
}

#[test]
fn a_tour_of_five_rooms_touches_nothing() {
    tour(seeds(2), 0.0);
}

/// Like a car, with the noise of the tables: it reverses, turns nowhere on the spot, and no
/// circle is too narrow.
#[test]
fn a_car_touches_nothing_and_stops_with_the_heading_it_was_asked_for() {
    let goals = [SE2::new(4.9, 2.0, 1.6), SE2::new(1.8, 7.0, 0.0), SE2::new(9.6, 4.5, -1.6)];
    let turning = goto::Options::default().turning;
    for seed in 0..seeds(1) {
        let header = header(seed, SE2::new(6.0, 4.5, 0.0));
        let waypoint = |goal: &SE2| goto::Waypoint {
            x_m: goal.x(),
            y_m: goal.y(),
            heading_rad: Some(goal.theta()),
        };
        let waypoints = goals.iter().map(waypoint).collect();
        let planner = goto::Planner::HybridAStar;
        let options = goto::Options { waypoints, planner, ..goto::Options::default() };
        let mut car = goto::driver(&told(&header), options).unwrap();
        let (mut commands, mut reached_at) = (Vec::new(), Vec::new());
        let (blocked, truths) = drive(&header, 6000, |tick| {
            let command = car.update(tick).command().unwrap();
            if reached_at.len() < car.task.reached() {
                reached_at.push(commands.len());
            }
            commands.push(command);
            command
        });
        for (at, goal) in reached_at.iter().zip(&goals) {
            let missed = truths[*at].boxminus(goal);
            println!("seed {seed}: tick {at}, missed by {missed:?}");
            assert!(missed.xy().norm() < 0.05 && missed.z.abs() < 0.15, "{goal:?}: {missed:?}");
        }
        assert_eq!((blocked, car.task.reached()), (0, 3), "seed {seed}");
        let reverse = commands.iter().filter(|command| command.v_m_s < 0.0).count();
        assert!(reverse > 20, "seed {seed}: {reverse} ticks in reverse");
        for Twist { v_m_s, omega_rad_s } in commands {
            let most_rad_s = (v_m_s / turning.turning_radius_m).abs() + 1e-9;
            assert!(omega_rad_s.abs() <= most_rad_s, "{omega_rad_s} rad/s at {v_m_s} m/s");
        }
    }
}

#[test]
fn nor_does_it_on_unequal_wheels() {
    tour(seeds(1), 0.01);
}

/// SLAM without a map, on the frames of a tour that one with a map drives: how far
/// what its scans met lies from the walls, root mean square and 95th percentile, m.
fn mapped_on_a_tour(seed: u64) -> (f64, f64) {
    let header = header(seed, SE2::new(6.0, 4.5, 0.0));
    let told = told(&header);
    let mut tour = goto::driver(&told, goto::Options::default()).unwrap();
    let mut slam = Slam::new(&Start { map: None, ..told }, &SlamOptions::default());
    let _ = drive(&header, 3900, |tick| {
        let _ = slam.update(tick);
        tour.update(tick).command().unwrap()
    });
    assert!(tour.task.reached() == 6 && slam.loops() > 10, "{} loops", slam.loops());
    let world = apartment();
    let points = slam.map().flat_map(|(_, points)| points);
    spread(points.map(|point| world.distance_to_nearest(point)).collect())
}

#[test]
fn a_map_made_on_a_tour_lies_within_five_centimetres_of_the_walls() {
    for seed in 0..seeds(1) {
        let (rms_m, most_m) = mapped_on_a_tour(seed);
        println!("seed {seed}: rms {rms_m:.4} m, 95 % within {most_m:.4} m");
        assert!(rms_m < 0.03 && most_m < 0.05, "seed {seed}: {rms_m} m, 95 % within {most_m} m");
    }
}

/// Share of the floor around the start, as far as walls let anybody go, that the
/// map has as free. Cells nearer to a wall than one and a half are left out: a
/// range that is wrong by a σ or two puts the wall there.
fn covered(map: &OccupancyMap, start: Point2<f64>) -> f64 {
    let world = apartment();
    let plan = OccupancyMap::of_world(&world, 0.1, 0.05);
    let frame = plan.frame;
    let mut floor = vec![frame.cell_at(start).unwrap()];
    let mut seen = vec![false; frame.cells()];
    seen[floor[0]] = true;
    let mut next = 0;
    while let Some(cell) = floor.get(next).copied() {
        next += 1;
        let (column, row) = ((cell % frame.width) as i64, (cell / frame.width) as i64);
        for (dx, dy) in [(1, 0), (0, 1), (-1, 0), (0, -1)] {
            let Some(beside) = frame.index(column + dx, row + dy) else { continue };
            if plan.cells[beside] == Cell::Free && !std::mem::replace(&mut seen[beside], true) {
                floor.push(beside);
            }
        }
    }
    let points = floor.iter().map(|cell| frame.centre(*cell));
    let points: Vec<_> = points.filter(|p| world.distance_to_nearest(*p) > 0.075).collect();
    let free = points.iter().filter(|p| map.at(**p) == Cell::Free).count();
    free as f64 / points.len() as f64
}

/// Explores until no frontier is left, or for some ticks: how many of them a wall held.
fn explored(header: &LogHeader, ticks: u64) -> (u64, explore::Explore) {
    // Where it starts only gives its map the frame of the plan.
    let told = Start { map: None, ..told(header) };
    let mut explorer = explore::driver(&told, explore::Options::default());
    let (blocked, _) = drive(header, ticks, |tick| {
        if explorer.task.done_at().is_some() {
            return Twist::default();
        }
        explorer.update(tick).command().unwrap()
    });
    (blocked, explorer.task)
}

#[test]
fn an_explorer_sees_the_whole_apartment_and_touches_nothing() {
    for seed in 0..seeds(1) {
        let header = header(seed, SE2::new(6.0, 4.5, 0.0));
        let (blocked, explorer) = explored(&header, 7500);
        let share = covered(&explorer.map(), Point2::new(6.0, 4.5));
        println!("seed {seed}: blocked {blocked}, {share:.3} seen, {:?}", explorer.done_at());
        assert_eq!(blocked, 0, "seed {seed}");
        assert!(share > 0.95 && explorer.done_at().is_some(), "seed {seed}: {share}");
    }
}

/// The wheels are bad and the laser sees little, so that scans alone lead the map astray.
#[test]
fn an_explorer_that_closes_loops_has_straight_walls() {
    for seed in 0..seeds(1) {
        let mut header = header(seed, SE2::new(6.0, 4.5, 0.0));
        header.config.robot.slip_std = 0.05;
        header.config.robot.radius_bias_right = 0.03;
        header.config.lidar.beams = 60;
        header.config.lidar.range_max_m = 3.5;
        let (blocked, explorer) = explored(&header, 9000);
        let (world, map) = (apartment(), explorer.map());
        let walls = (0..map.frame.cells()).filter(|cell| map.cells[*cell] == Cell::Occupied);
        let off_m = walls.map(|cell| world.distance_to_nearest(map.frame.centre(cell)));
        let (rms_m, most_m) = spread(off_m.collect());
        let done_at = explorer.done_at();
        println!("seed {seed}: blocked {blocked}, rms {rms_m:.3} m, 95 % within {most_m:.3} m");
        assert!(blocked == 0 && done_at.is_some(), "seed {seed}: blocked {blocked}, {done_at:?}");
        assert!(most_m < 0.15, "seed {seed}: 95 % of the walls within {most_m} m");
    }
}

/// The log again, to its own driver: from the file, and by a server.
fn answers_again(log: &Path, ticks: u64) {
    let said = about("verify", log, &["--clients"]).expect(0).stdout;
    assert!(said.starts_with(&format!("bit-exact: {ticks} ticks")), "{said}");
    let comparison = &replay(log, folder().path(), &[]).expect(0).json()["comparison"];
    assert_eq!(comparison["equal"], comparison["compared"]);
    assert!(comparison["compared"].as_u64().unwrap() >= ticks, "{comparison}");
}

#[test]
fn a_tour_by_processes_is_in_its_log_and_comes_again() {
    let place = folder();
    // Larger ticks make fewer of them; a scan still comes ten times a second.
    let set = ["--set", "dt_s=0.05", "--set", "scan_every=2", "--ticks", "1700"];
    let tour = filter_scenario("tour.toml");
    let args = [&[tour.as_str(), "--without", "dead-reckoning"], &set[..]].concat();
    let report = launch("tour", &place.at("run"), &args);
    assert_eq!(report["blocked_ticks"], 0);
    let log = log_of(&report);
    let truths = truths(&log);
    assert_eq!(visited(&truths, 0.3), [true; 5]);
    let home = truths[truths.len() - 1].translation() - SE2::new(6.0, 4.5, 0.0).translation();
    assert!(home.norm() < 0.3, "{home}");
    answers_again(&log, 1700);
}

#[test]
fn wanderers_and_explorers_answer_the_same_again() {
    let place = folder();
    for (name, ticks) in [("wander", 500), ("explore", 250)] {
        let (scenario, ticks) = (filter_scenario(&format!("{name}.toml")), ticks.to_string());
        let out = place.at(name);
        let report = launch(name, &out, &[scenario.as_str(), "--ticks", &ticks]);
        assert_eq!(report["blocked_ticks"], 0);
        answers_again(&log_of(&report), ticks.parse().unwrap());
    }
}
