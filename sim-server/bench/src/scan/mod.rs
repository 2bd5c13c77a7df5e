//! `bench scan`: what a beam costs, beside a ray for each beam.
//!
//! * [`ways`]: the ways to scan that are compared;
//! * [`results`]: what a run of the bench comes to;
//! * [`section`]: the same, on the page.
//!
//! The worlds are the Apartment and generated ones (see
//! [`rusty_geometry::generated`]). In each, all ways scan from the same poses in
//! turns; before, the kernel's ranges are compared with those of the reference,
//! bit by bit, and hashed, so that machines can be compared.

pub mod results;
pub mod section;
pub mod ways;

use std::hint::black_box;
use std::time::Duration;

use rusty_contract::LidarConfig;
use rusty_geometry::generated::{Density, Pattern, Recipe, free_poses};
use rusty_geometry::{SE2, World, WorldError, apartment};
use xxhash_rust::xxh3::Xxh3;

use super::alternate::{Rival, alternate};
use results::{Case, ScanResults};
use ways::{Kernel, Noisy, Parry, Rays, Way};

/// Seed of worlds and poses.
const SEED: u64 = 20;
/// Poses in each world.
const POSES: usize = 32;
/// How far every pose is from all walls, m.
const CLEARANCE_M: f64 = 0.1;
/// Farther than this, m, parry's answer counts as another one.
const OTHER_M: f64 = 1e-6;

/// What to measure.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Sizes of generated worlds, in walls.
    pub walls: Vec<usize>,
    /// Numbers of beams over the full circle.
    pub beams: Vec<u32>,
    /// How generated worlds grow.
    pub densities: Vec<Density>,
    /// How their walls stand.
    pub patterns: Vec<Pattern>,
    /// How long each case is measured, after its world is made.
    pub time: Duration,
}

impl Default for Plan {
    fn default() -> Self {
        Self {
            walls: vec![64, 512, 4096, 32_768],
            beams: vec![180, 1080],
            densities: vec![Density::Constant, Density::Area],
            patterns: vec![Pattern::Rooms, Pattern::Segments],
            time: Duration::from_millis(500),
        }
    }
}

impl Plan {
    /// The generated worlds, smaller ones first.
    #[must_use]
    pub fn recipes(&self) -> Vec<Recipe> {
        let mut recipes = Vec::new();
        for &pattern in &self.patterns {
            for &density in &self.densities {
                for &walls in &self.walls {
                    recipes.push(Recipe { pattern, density, walls, seed: SEED });
                }
            }
        }
        recipes
    }

    /// Names of the worlds in order, the Apartment first.
    #[must_use]
    pub fn worlds(&self) -> Vec<String> {
        let generated = self.recipes().into_iter().map(|recipe| recipe.name());
        std::iter::once("apartment".to_owned()).chain(generated).collect()
    }
}

/// Measures; `on_case` hears the name of each world and the number of beams
/// before their turn, and may look at the machine.
///
/// # Errors
/// [`WorldError`] if a recipe makes no valid world, which its tests rule out.
pub fn run(plan: &Plan, mut on_case: impl FnMut(&str, u32)) -> Result<ScanResults, WorldError> {
    let mut cases = Vec::new();
    let mut measure = |world: &World, plan: &Plan| {
        for &beams in &plan.beams {
            on_case(world.name(), beams);
            cases.push(case(world, beams, plan.time));
        }
    };
    measure(&apartment(), plan);
    for recipe in plan.recipes() {
        measure(&World::new(recipe.spec())?, plan);
    }
    Ok(ScanResults::of(cases))
}

/// One world with one number of beams.
fn case(world: &World, beams: u32, time: Duration) -> Case {
    let config = LidarConfig { beams, dropout: 0.02, ..LidarConfig::default() };
    let poses = free_poses(world, SEED, POSES, CLEARANCE_M);
    let check = check(world, &config, &poses);
    let mut rivals = [
        rival(Kernel::new(world, &config), &poses, beams),
        rival(Rays::new(world, &config), &poses, beams),
        rival(Parry::new(world, &config), &poses, beams),
        rival(Noisy::new(world, &config), &poses, beams),
    ];
    let rounds = alternate(&mut rivals, time);
    let [kernel, rays, parry, noisy] = &rivals;
    Case {
        world: world.name().to_owned(),
        walls: world.walls().len(),
        beams,
        rounds,
        kernel_ns_per_beam: kernel.ns(),
        rays_ns_per_beam: rays.ns(),
        parry_ns_per_beam: parry.ns(),
        rays_over_kernel: rays.over(kernel),
        parry_over_kernel: parry.over(kernel),
        noise_ns_per_beam: noisy.beyond(kernel),
        beams_compared: check.compared,
        beams_that_differ: check.differ,
        parry_differs: check.parry_differs,
        ranges_hash: check.ranges_hash,
    }
}

/// A way as a rival: a batch is a scan from each pose.
fn rival<'a>(mut way: impl Way + 'a, poses: &'a [SE2], beams: u32) -> Rival<'a> {
    let mut ranges_m = vec![0.0; beams as usize];
    Rival::new(poses.len() * beams as usize, move || {
        for pose in poses {
            way.scan(pose, &mut ranges_m);
            black_box(&mut ranges_m);
        }
    })
}

/// What comparing the ways' answers came to.
struct Check {
    compared: usize,
    differ: usize,
    parry_differs: usize,
    ranges_hash: String,
}

/// Compares what the ways answer from all poses.
fn check(world: &World, config: &LidarConfig, poses: &[SE2]) -> Check {
    let mut found = Check { compared: 0, differ: 0, parry_differs: 0, ranges_hash: String::new() };
    let mut hash = Xxh3::new();
    let ranges_m = || vec![f64::NAN; config.beams as usize];
    let (mut kernel_m, mut rays_m, mut parry_m) = (ranges_m(), ranges_m(), ranges_m());
    let (mut kernel, mut rays) = (Kernel::new(world, config), Rays::new(world, config));
    let mut parry = Parry::new(world, config);
    for pose in poses {
        kernel.scan(pose, &mut kernel_m);
        rays.scan(pose, &mut rays_m);
        parry.scan(pose, &mut parry_m);
        for ((kernel_m, rays_m), parry_m) in kernel_m.iter().zip(&rays_m).zip(&parry_m) {
            found.compared += 1;
            found.differ += usize::from(kernel_m.to_bits() != rays_m.to_bits());
            let alike = (parry_m - rays_m).abs() <= OTHER_M;
            found.parry_differs += usize::from(!alike);
            hash.update(&kernel_m.to_bits().to_le_bytes());
        }
    }
    found.ranges_hash = format!("{:016x}", hash.digest());
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn small() -> Plan {
        Plan { walls: vec![64, 512], beams: vec![180], time: Duration::ZERO, ..Plan::default() }
    }

    #[test]
    fn all_ways_see_the_same_and_a_repetition_has_the_same_hashes() {
        let mut heard = Vec::new();
        let results = run(&small(), |world, beams| heard.push(format!("{world} {beams}"))).unwrap();
        assert_eq!(heard.len(), 9);
        assert_eq!(results.cases.len(), 9);
        assert_eq!(results.beams_that_differ, 0);
        assert_eq!(results.beams_compared, 9 * 32 * 180);
        // Parry has a formula of its own; walls that meet at a corner it may see
        // from the other side, but not often.
        let parry: usize = results.cases.iter().map(|c| c.parry_differs).sum();
        assert!(parry * 1000 < results.beams_compared, "{parry}");
        let again = run(&small(), |_, _| {}).unwrap();
        assert_eq!(again.ranges_hash, results.ranges_hash);
        let worlds: Vec<&str> = results.cases.iter().map(|c| c.world.as_str()).collect();
        assert_eq!(worlds, small().worlds());
    }
}
