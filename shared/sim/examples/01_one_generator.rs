//! Break it on purpose: one random generator for the whole world.
//!
//! Almost every simulator starts like this: one generator, seeded once, and
//! code that needs a number takes the next. It repeats itself perfectly. But add
//! one beam to the LiDAR, and the *wheels* slip differently, because the beam
//! took a number that would have been theirs. Rusty's world gives every source
//! of noise a separate stream and every tick a place in it.
//!
//! ```sh
//! cargo run --example 01_one_generator -p rusty-sim
//! ```

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng as _, SeedableRng as _};
use rusty_contract::{Frame, LidarConfig, RobotConfig, RunConfig, ScriptConfig};
use rusty_geometry::normal::standard_normal;
use rusty_geometry::{EncoderCounts, Hit, SE2, Twist, World, apartment, odometry_delta, trig};
use rusty_sim::{Lidar, Robot, Sim, SimError};

/// A wide circle in the living room.
const COMMAND: Twist = Twist { v_m_s: 0.5, omega_rad_s: 0.6 };

fn config(beams: u32) -> RunConfig {
    RunConfig {
        scenario: "one-generator".to_owned(),
        seed: 42,
        ticks: 1000,
        dt_s: 0.02,
        scan_every: 5,
        start: SE2::new(9.6, 3.0, 0.0),
        robot: RobotConfig::default(),
        lidar: LidarConfig { beams, ..LidarConfig::default() },
        script: ScriptConfig::Driver {},
        world: apartment().spec().clone(),
        sensors: rusty_contract::Sensors::default(),
        kidnappings: Vec::new(),
        walkers: Vec::new(),
        crowd: None,
        events: Vec::new(),
        fleet: None,
        patches: Vec::new(),
    }
}

/// Where a robot went, and where dead reckoning believes it is in the end.
struct Path {
    truth: Vec<SE2>,
    reckoned: SE2,
}

impl Path {
    /// How far off dead reckoning is in the end, m.
    fn drift_m(&self) -> f64 {
        self.truth.last().map_or(0.0, |truth| distance_m(truth, &self.reckoned))
    }
}

fn distance_m(a: &SE2, b: &SE2) -> f64 {
    let d = a.translation() - b.translation();
    trig::hypot(d.x, d.y)
}

/// The broken world: code that needs a number takes the next.
fn with_one_generator(beams: u32) -> Result<Path, SimError> {
    let config = config(beams);
    let world = World::new(config.world.clone())?;
    let drive = config.robot.nominal().drive;
    let mut robot = Robot::new(&config.robot, config.start);
    let mut lidar = Lidar::new(&config.lidar);
    let mut hits = vec![Hit { distance_m: 0.0, material: None }; lidar.beams()];
    let mut ranges_m = vec![0.0; lidar.beams()];

    let mut generator = ChaCha8Rng::seed_from_u64(config.seed);
    let mut draw = || standard_normal(generator.next_u64());

    let mut path = Path { truth: Vec::new(), reckoned: config.start };
    let mut counted = EncoderCounts::default();
    for tick in 0..config.ticks {
        let slip_z = [draw(), draw()];
        let _ = robot.step(&world, COMMAND, config.dt_s, slip_z);
        if tick % config.scan_every == 0 {
            lidar.ranges_and_materials(&world, &robot.pose_in_world(), &mut hits);
            for (range_m, hit) in ranges_m.iter_mut().zip(&hits) {
                *range_m = hit.distance_m + config.lidar.range_std_m * draw();
            }
        }
        let delta = odometry_delta(counted, robot.encoder_ticks(), &drive);
        path.reckoned = path.reckoned.boxplus(&delta);
        counted = robot.encoder_ticks();
        path.truth.push(robot.pose_in_world());
    }
    Ok(path)
}

/// Rusty's world: every number has a name and a place.
fn with_named_streams(beams: u32) -> Result<Path, SimError> {
    let config = config(beams);
    let drive = config.robot.nominal().drive;
    let mut path = Path { truth: Vec::new(), reckoned: config.start };
    let mut counted = EncoderCounts::default();
    let mut sim = Sim::new(config)?;
    let mut frame = Frame::boxed();
    for _ in 0..sim.config().ticks {
        let _ = sim.step(Some(COMMAND), &mut frame);
        path.reckoned = path.reckoned.boxplus(&odometry_delta(counted, frame.encoders(), &drive));
        counted = frame.encoders();
        path.truth.push(sim.truth());
    }
    Ok(path)
}

fn bits(pose: &SE2) -> [u64; 3] {
    [pose.x(), pose.y(), pose.theta()].map(f64::to_bits)
}

/// The first tick after which two robots do not stand at the same place, to
/// the last bit.
fn first_difference(a: &Path, b: &Path) -> Option<usize> {
    a.truth.iter().zip(&b.truth).position(|(a, b)| bits(a) != bits(b))
}

fn report(world: &str, few: &Path, more: &Path) {
    println!("{world}, 180 beams and 181:");
    match first_difference(few, more) {
        None => println!("  the same path in all {} ticks, to the last bit", few.truth.len()),
        Some(tick) => {
            let (a, b) = (few.truth[tick], more.truth[tick]);
            println!("  two paths from tick {tick} on:");
            println!("    x = {:.17} m, bits {:016x}", a.x(), a.x().to_bits());
            println!("    x = {:.17} m, bits {:016x}", b.x(), b.x().to_bits());
            if let (Some(a), Some(b)) = (few.truth.last(), more.truth.last()) {
                println!("  in the end they are {:.1} cm apart", 100.0 * distance_m(a, b));
            }
        }
    }
    println!(
        "  dead reckoning, which never looks at a scan, is off by {:.2} cm and {:.2} cm\n",
        100.0 * few.drift_m(),
        100.0 * more.drift_m()
    );
}

fn main() -> Result<(), SimError> {
    report("one generator for all", &with_one_generator(180)?, &with_one_generator(181)?);
    report("a stream for each source", &with_named_streams(180)?, &with_named_streams(181)?);
    println!(
        "What is lost: \"does one more beam help my filter?\" Under one generator the two scores \
         come from two different journeys, and their difference is luck, not beams."
    );
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_more_beam_moves_the_robot_of_the_broken_world() {
        let (few, more) = (with_one_generator(180).unwrap(), with_one_generator(181).unwrap());
        // The first scan is taken in tick 0: the wheels of tick 1 feel it.
        assert_eq!(first_difference(&few, &more), Some(1));
        assert!(few.drift_m().to_bits() != more.drift_m().to_bits());
        // It is no world of chance: it repeats itself, which is what hides it.
        assert_eq!(first_difference(&few, &with_one_generator(180).unwrap()), None);
    }

    #[test]
    fn one_more_beam_moves_nothing_in_rusty_s_world() {
        let (few, more) = (with_named_streams(180).unwrap(), with_named_streams(181).unwrap());
        assert_eq!(first_difference(&few, &more), None);
        assert_eq!(few.drift_m().to_bits(), more.drift_m().to_bits());
        // And the robot did drive.
        assert!(few.truth.windows(2).all(|pair| distance_m(&pair[0], &pair[1]) > 0.0));
    }
}
