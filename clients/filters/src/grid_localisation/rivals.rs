//! Modes that explain a scan equally well.
//!
//! The sum over the cells of a mode depends a little on the distance from the true pose to
//! the nearest centre. In two rooms that look the same this difference has one sign for
//! many scans, and it would select a room. So between modes small differences of the
//! likelihood do not count, as in the module `strata` of [`crate::mcl`].

use rusty_geometry::trig;

use super::cells::Cells;
use crate::kld::Bins;
use crate::mcl::Particles;

/// A difference of ln p between modes that their cells can make.
const OF_CELLS: f64 = 0.3;

/// Corrects the masses of the modes after a scan. `likely` has the likely cells, and is
/// written again.
pub(super) fn level(cells: &mut Cells, likely: &mut Particles, bins: &mut Bins) {
    bins.fill(likely.poses());
    let mode_of = bins.modes();
    let first = mode_of.first();
    if mode_of.iter().all(|mode| Some(mode) == first) {
        return;
    }
    let mut sums = vec![(0.0, 0.0); likely.count()];
    for ((mode, mass), prior) in mode_of.iter().zip(&likely.weights).zip(cells.priors()) {
        let (masses, priors) = &mut sums[*mode as usize];
        *masses += mass;
        *priors += prior;
    }
    let heavier = |best: (f64, f64), sums: &(f64, f64)| if sums.0 > best.0 { *sums } else { best };
    let heaviest = sums.iter().fold((0.0, 0.0), heavier);
    let factor = |(masses, priors): &(f64, f64)| {
        let difference = trig::ln(masses / priors) - trig::ln(heaviest.0 / heaviest.1);
        trig::exp(-difference.clamp(-OF_CELLS, OF_CELLS))
    };
    let is_mode = |(masses, priors): &(f64, f64)| *masses > 0.0 && *priors > 0.0;
    let factors: Vec<f64> =
        sums.iter().map(|sums| if is_mode(sums) { factor(sums) } else { 1.0 }).collect();
    cells.scale(mode_of.iter().map(|mode| factors[*mode as usize]));
    cells.write_likely(likely);
}
