//! What `bench scan` comes to.

use rusty_contract::outln;
use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::xxh3_64;

use crate::quantiles::Spread;

/// One world, scanned with one number of beams.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Case {
    /// The world's name.
    pub world: String,
    /// Its walls.
    pub walls: usize,
    /// Beams of a scan.
    pub beams: u32,
    /// Rounds in which all ways had their turn.
    pub rounds: usize,
    /// The kernel, ns per beam.
    pub kernel_ns_per_beam: Spread,
    /// The reference, a ray for each beam, ns per beam.
    pub rays_ns_per_beam: Spread,
    /// Parry's own ray cast for each beam, ns per beam.
    pub parry_ns_per_beam: Spread,
    /// How many times longer the reference takes.
    pub rays_over_kernel: Spread,
    /// How many times longer parry takes.
    pub parry_over_kernel: Spread,
    /// Noise and dropout on top of the kernel, ns per beam.
    pub noise_ns_per_beam: Spread,
    /// Beams for which kernel and reference were compared.
    pub beams_compared: usize,
    /// Of these, those whose bits differ.
    pub beams_that_differ: usize,
    /// Of these, those for which parry says something else by over 1 µm.
    pub parry_differs: usize,
    /// XXH3-64 of the kernel's ranges: the same on every machine.
    pub ranges_hash: String,
}

/// All cases.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ScanResults {
    /// World by world, the Apartment first.
    pub cases: Vec<Case>,
    /// Beams for which kernel and reference were compared.
    pub beams_compared: usize,
    /// Of these, those whose bits differ.
    pub beams_that_differ: usize,
    /// Of the cases' hashes: the same on every machine for the same cases.
    pub ranges_hash: String,
}

impl ScanResults {
    /// Of these cases.
    #[must_use]
    pub fn of(cases: Vec<Case>) -> Self {
        let hashes: String = cases.iter().map(|case| case.ranges_hash.as_str()).collect();
        Self {
            beams_compared: cases.iter().map(|case| case.beams_compared).sum(),
            beams_that_differ: cases.iter().map(|case| case.beams_that_differ).sum(),
            ranges_hash: format!("{:016x}", xxh3_64(hashes.as_bytes())),
            cases,
        }
    }

    /// Prints the table.
    pub fn print(&self) {
        outln!(
            "{:24} {:>5}  {:>8} {:>8} {:>8}  {:>7} {:>7}  {:>7}",
            "ns per beam",
            "beams",
            "kernel",
            "rays",
            "parry",
            "rays/k",
            "parry/k",
            "noise"
        );
        for case in &self.cases {
            outln!(
                "{:24} {:>5}  {:>8.1} {:>8.1} {:>8.1}  {:>6.1}x {:>6.1}x  {:>+7.1}",
                case.world,
                case.beams,
                case.kernel_ns_per_beam.median,
                case.rays_ns_per_beam.median,
                case.parry_ns_per_beam.median,
                case.rays_over_kernel.median,
                case.parry_over_kernel.median,
                case.noise_ns_per_beam.median
            );
        }
        outln!("");
        outln!("kernel   a scan as one problem; rays: the same bits, a ray for each beam");
        outln!("parry    its own ray cast on a polyline; noise: noise and dropout on top");
        outln!(
            "bits     {} of {} beams differ between kernel and rays; ranges {}",
            self.beams_that_differ,
            self.beams_compared,
            self.ranges_hash
        );
        let parry: usize = self.cases.iter().map(|case| case.parry_differs).sum();
        outln!("         parry answers {parry} of them otherwise by more than 1 µm");
    }
}
