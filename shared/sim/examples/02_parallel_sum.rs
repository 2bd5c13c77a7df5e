//! Break it on purpose: a sum in parallel.
//!
//! How well does a scan fit a pose? Every filter answers with a sum over beams.
//! Let every thread sum its share and add what the threads bring, and the last
//! bits depend on how many threads there were and on which came home first:
//! addition of floating-point numbers is not associative. Let the threads work
//! out the *terms* and add those in the order of the beams, and no machine can
//! tell how many there were.
//!
//! ```sh
//! cargo run --example 02_parallel_sum -p rusty-sim
//! ```

use std::thread;

use rusty_contract::{Frame, LidarConfig, RobotConfig, RunConfig, ScriptConfig};
use rusty_geometry::{Hit, SE2, apartment};
use rusty_sim::{Lidar, Sim, SimError};

/// From a laptop on battery to a desktop.
const THREADS: std::ops::RangeInclusive<usize> = 1..=8;

/// One beam: what was measured, what a map would predict, m.
#[derive(Clone, Copy)]
struct Beam {
    measured_m: f64,
    expected_m: f64,
}

impl Beam {
    /// Its part of −2·ln of the scan's likelihood, σ = 2 cm.
    fn misfit(&self) -> f64 {
        let z = (self.measured_m - self.expected_m) / 0.02;
        z * z
    }
}

/// A real scan of the Apartment, and what it should be at the true pose.
fn scan() -> Result<Vec<Beam>, SimError> {
    let mut sim = Sim::new(RunConfig {
        scenario: "parallel-sum".to_owned(),
        seed: 42,
        ticks: 1,
        dt_s: 0.02,
        scan_every: 1,
        start: SE2::new(6.0, 4.5, 0.3),
        robot: RobotConfig::default(),
        lidar: LidarConfig::default(),
        script: ScriptConfig::Straight { v_m_s: 0.5 },
        world: apartment().spec().clone(),
        sensors: rusty_contract::Sensors::default(),
        kidnappings: Vec::new(),
        walkers: Vec::new(),
        crowd: None,
        events: Vec::new(),
        fleet: None,
        patches: Vec::new(),
    })?;
    let mut frame = Frame::boxed();
    let _ = sim.step(None, &mut frame);
    let measured_m = frame.ranges_m().unwrap_or_default();
    let mut hits = vec![Hit { distance_m: 0.0, material: None }; measured_m.len()];
    let mut lidar = Lidar::new(&sim.config().lidar);
    lidar.ranges_and_materials(sim.world(), &sim.truth(), &mut hits);
    let beams = measured_m.iter().zip(&hits);
    Ok(beams.map(|(m, hit)| Beam { measured_m: *m, expected_m: hit.distance_m }).collect())
}

/// Runs `work` on `threads` shares of the beams at once; what each thread
/// brings, in the order of the shares. A thread that fails takes all down.
fn in_shares<T: Send>(beams: &[Beam], threads: usize, work: fn(&[Beam]) -> T) -> Vec<T> {
    let share = beams.len().div_ceil(threads);
    thread::scope(|scope| {
        let running: Vec<_> =
            beams.chunks(share).map(|beams| scope.spawn(move || work(beams))).collect();
        running
            .into_iter()
            .map(|thread| thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
            .collect()
    })
}

/// Every thread sums its share.
fn shares(beams: &[Beam], threads: usize) -> Vec<f64> {
    in_shares(beams, threads, |beams| beams.iter().map(Beam::misfit).sum())
}

/// Broken: the shares are added. `home` says in which order they are home.
fn sum_of_shares(beams: &[Beam], threads: usize, home: impl Fn(&mut Vec<f64>)) -> f64 {
    let mut shares = shares(beams, threads);
    home(&mut shares);
    shares.iter().sum()
}

/// Sound: threads bring terms, and the terms are added in the order of beams.
fn sum_in_order(beams: &[Beam], threads: usize) -> f64 {
    let terms =
        in_shares(beams, threads, |beams| beams.iter().map(Beam::misfit).collect::<Vec<f64>>());
    terms.iter().flatten().sum()
}

fn main() -> Result<(), SimError> {
    let beams = scan()?;
    println!("how well {} beams fit, by 1 to 8 threads:\n", beams.len());
    println!("threads  shares added                 last home first       terms in order");
    for threads in THREADS {
        let forth = sum_of_shares(&beams, threads, |_| ());
        let back = sum_of_shares(&beams, threads, |shares| shares.reverse());
        let ordered = sum_in_order(&beams, threads);
        println!(
            "{threads:7}  {:016x}             {:016x}      {:016x}",
            forth.to_bits(),
            back.to_bits(),
            ordered.to_bits()
        );
    }
    let one = sum_in_order(&beams, 1);
    println!("\nAll of them are {one:.10}, and no two machines need agree on the rest.");
    println!(
        "What is lost: a particle filter that weighs by such a sum draws another particle as soon \
         as a weight falls on the other side of a random number, and from there on the same seed \
         gives another estimate: on a machine with more cores or, where shares are added as they \
         come, in the next run on the same one. A benchmark of it measures the scheduler too."
    );
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    fn distinct(sum: impl Fn(usize) -> f64) -> usize {
        THREADS.map(|threads| sum(threads).to_bits()).collect::<BTreeSet<u64>>().len()
    }

    #[test]
    fn the_sum_of_shares_depends_on_how_many_there_are() {
        let beams = scan().unwrap();
        assert_eq!(beams.len(), 180);
        assert!(distinct(|threads| sum_of_shares(&beams, threads, |_| ())) > 1);
        // All of them are right as far as anyone would look.
        let one = sum_in_order(&beams, 1);
        for threads in THREADS {
            let relative = (sum_of_shares(&beams, threads, |_| ()) - one).abs() / one;
            assert!(relative < 1e-12, "{threads} threads: {relative}");
        }
    }

    #[test]
    fn the_sum_of_shares_depends_on_who_is_home_first() {
        let beams = scan().unwrap();
        let sum = |threads, home: fn(&mut Vec<f64>)| sum_of_shares(&beams, threads, home).to_bits();
        let differ =
            |threads: &usize| sum(*threads, |_| ()) != sum(*threads, |shares| shares.reverse());
        assert!(THREADS.filter(differ).count() > 0);
    }

    #[test]
    fn the_ordered_sum_is_one_and_the_same() {
        let beams = scan().unwrap();
        assert_eq!(distinct(|threads| sum_in_order(&beams, threads)), 1);
    }
}
