//! `bench scan`: what a beam costs, compared with a ray for each beam.
//!
//! `ways` has the ways to scan that are compared.
//!
//! The worlds are the Apartment and generated ones (see
//! [`rusty_geometry::generated`]). In each, all ways scan from the same poses in
//! turns; before, the kernel's ranges are compared with those of the reference,
//! bit by bit, and hashed, so that machines can be compared.

mod ways;

use std::hint::black_box;
use std::time::Duration;

use rusty_contract::LidarConfig;
use rusty_geometry::generated::{Density, Pattern, Recipe, free_poses};
use rusty_geometry::{SE2, World, WorldError, apartment};
use xxhash_rust::xxh3::{Xxh3, xxh3_64};

use super::alternate::{Rival, alternate};
use super::results::{Figure, Results, Row};

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

/// Returns the names of the rows of the usual plan.
#[must_use]
pub fn rows() -> Vec<String> {
    let plan = Plan::default();
    let of = |world: &String| plan.beams.iter().map(|b| label(world, *b)).collect::<Vec<_>>();
    plan.worlds().iter().flat_map(of).collect()
}

fn label(world: &str, beams: u32) -> String {
    format!("{world}, {beams}")
}

/// Measures; `on_case` receives the name of each world and the number of beams
/// before their turn, and may look at the machine.
///
/// # Errors
/// [`WorldError`] if a recipe makes no valid world, which its tests rule out.
pub fn run(plan: &Plan, mut on_case: impl FnMut(&str, u32)) -> Result<Results, WorldError> {
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
    Ok(results(plan, cases))
}

/// The cases, their sums, and how the cost of a beam grows with the world.
fn results(plan: &Plan, cases: Vec<Row>) -> Results {
    let sum = |name: &str| cases.iter().map(|case| case.number(name) as u64).sum::<u64>();
    let hash = |case: &Row| match case.figures.get("ranges_hash") {
        Some(Figure::Text(hash)) => hash.clone(),
        _ => String::new(),
    };
    let hashes: String = cases.iter().map(hash).collect();
    let sums =
        ["beams_compared", "beams_that_differ", "parry_differs"].map(|name| (name, sum(name)));
    let growths = growths(plan, &cases);
    let tables: [&[_]; 2] = [
        &[
            ("kernel_ns_per_beam", 1),
            ("rays_ns_per_beam", 1),
            ("parry_ns_per_beam", 1),
            ("rays_over_kernel", 1),
            ("parry_over_kernel", 1),
            ("noise_ns_per_beam", 1),
        ],
        &[("growth", 1)],
    ];
    let results = Results::new(&tables, cases.into_iter().chain(growths))
        .fact("ranges_hash", format!("{:016x}", xxh3_64(hashes.as_bytes())));
    sums.into_iter().fold(results, |results, (name, sum)| results.fact(name, sum))
}

/// For each kind of generated world and number of beams: the kernel's cost in the
/// largest world over that in the smallest.
fn growths(plan: &Plan, cases: &[Row]) -> Vec<Row> {
    let (small, large) = (plan.walls.iter().min(), plan.walls.iter().max());
    let Some((&small, &large)) = small.zip(large).filter(|(small, large)| small < large) else {
        return Vec::new();
    };
    let mut growths = Vec::new();
    for recipe in plan.recipes().into_iter().filter(|recipe| recipe.walls == small) {
        for &beams in &plan.beams {
            let cost = |walls| {
                let name = label(&Recipe { walls, ..recipe }.name(), beams);
                let case = cases.iter().find(|case| case.name == name);
                case.map(|case| case.number("kernel_ns_per_beam"))
            };
            if let Some((large_ns, small_ns)) = cost(large).zip(cost(small)) {
                let name = format!("{} to {large}", recipe.name());
                growths.push(Row::new(label(&name, beams)).with("growth", large_ns / small_ns));
            }
        }
    }
    growths
}

/// One world with one number of beams.
fn case(world: &World, beams: u32, time: Duration) -> Row {
    let config = LidarConfig { beams, dropout: 0.02, ..LidarConfig::default() };
    let poses = free_poses(world, SEED, POSES, CLEARANCE_M);
    let check = check(world, &config, &poses);
    let mut rivals = [
        rival(ways::kernel(world, &config), &poses, beams),
        rival(ways::rays(world, &config), &poses, beams),
        rival(ways::parry(world, &config), &poses, beams),
        rival(ways::noisy(world, &config), &poses, beams),
    ];
    let rounds = alternate(&mut rivals, time);
    let [kernel, rays, parry, noisy] = &rivals;
    Row::new(label(world.name(), beams))
        .with("walls", world.walls().len())
        .with("beams", u64::from(beams))
        .with("rounds", rounds)
        .with("kernel_ns_per_beam", kernel.ns())
        .with("rays_ns_per_beam", rays.ns())
        .with("parry_ns_per_beam", parry.ns())
        .with("rays_over_kernel", rays.over(kernel))
        .with("parry_over_kernel", parry.over(kernel))
        .with("noise_ns_per_beam", noisy.beyond(kernel))
        .with("beams_compared", check.compared)
        .with("beams_that_differ", check.differ)
        .with("parry_differs", check.parry_differs)
        .with("ranges_hash", check.ranges_hash)
}

/// A way as a rival: a batch is a scan from each pose.
fn rival<'a>(
    mut scan: impl FnMut(&SE2, &mut [f64]) + 'a,
    poses: &'a [SE2],
    beams: u32,
) -> Rival<'a> {
    let mut ranges_m = vec![0.0; beams as usize];
    Rival::new(poses.len() * beams as usize, move || {
        for pose in poses {
            scan(pose, &mut ranges_m);
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
    let (mut kernel, mut rays) = (ways::kernel(world, config), ways::rays(world, config));
    let mut parry = ways::parry(world, config);
    for pose in poses {
        kernel(pose, &mut kernel_m);
        rays(pose, &mut rays_m);
        parry(pose, &mut parry_m);
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
        let mut received = Vec::new();
        let results =
            run(&small(), |world, beams| received.push(format!("{world} {beams}"))).unwrap();
        assert_eq!(received.len(), 9);
        let cases: Vec<&str> = results.rows_of(&results.tables[0]).map(|row| &*row.name).collect();
        let expected = small().worlds().into_iter().map(|world| label(&world, 180));
        assert_eq!(cases, expected.collect::<Vec<_>>());
        assert_eq!(results.facts["beams_that_differ"], 0);
        assert_eq!(results.facts["beams_compared"], 9 * 32 * 180);
        // Parry has a different formula; walls that meet at a corner it may see
        // from the other side, but not often.
        let parry = results.facts["parry_differs"].as_u64().unwrap();
        assert!(parry * 1000 < 9 * 32 * 180, "{parry}");
        let again = run(&small(), |_, _| {}).unwrap();
        assert_eq!(again.facts["ranges_hash"], results.facts["ranges_hash"]);
    }

    #[test]
    fn a_row_for_each_world_and_number_of_beams() {
        let rows = rows();
        assert_eq!(rows.len(), 34);
        assert_eq!((&*rows[0], &*rows[33]), ("apartment, 180", "segments-area-32768, 1080"));
    }

    #[test]
    fn growth_is_the_largest_world_s_cost_over_the_smallest_s() {
        let plan = Plan { densities: vec![Density::Area], ..small() };
        let cost = |name: &str, ns: f64| Row::new(name).with("kernel_ns_per_beam", ns);
        let cases = [cost("rooms-area-512, 180", 20.0), cost("rooms-area-64, 180", 10.0)];
        let [growth] = &growths(&plan, &cases)[..] else { panic!() };
        assert_eq!((&*growth.name, growth.number("growth")), ("rooms-area-64 to 512, 180", 2.0));
    }
}
