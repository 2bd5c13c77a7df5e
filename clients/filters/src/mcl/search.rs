//! Looking for the robot elsewhere, while the belief stays as it is.
//!
//! Table 8.3 of *Probabilistic Robotics* mixes particles from everywhere with
//! those that there are. With a laser that cannot work: a stranger a hand's
//! breadth from the truth explains a scan worse than a particle that fits some
//! other room to the millimetre, though not quite, and is lost with the next
//! drawing. So the strangers are a separate cloud that localises globally
//! as at the beginning, from the first scan that arouses suspicion on. When it
//! has settled, the two are compared at one and the same scan: the one that
//! explains it better is the belief. If that is the old one, the suspicion is
//! halved, and what remains of it starts another search. If another place explains the
//! scan as well, the filter does not answer, and the suspicion remains. It remains as well if
//! scans of two places (module `hypotheses`) tell that the robot is elsewhere: a robot that
//! people stop in a wrong place would otherwise believe it after a few searches. The place
//! that is better is so with all beams, and without those that end in front of all walls: a robot
//! that people stand around would otherwise be found in the smallest room. Nearest in the
//! literature: S. Lenser, M. Veloso, *Sensor Resetting Localization for Poorly Modelled Mobile
//! Robots* (ICRA 2000).

use super::cloud::Cloud;
use super::mode::Modes;
use super::sensor::Sensor;
use super::{FreeSpace, Options};
use crate::{Motion, Random};

/// By how much better a beam has to be explained elsewhere.
const BETTER: f64 = 1.02;
/// By how much worse a beam may be explained elsewhere for that place to be a rival.
const AS_WELL: f64 = 1.1;
/// A search that has not settled after this many scans has failed. The belief of a
/// robot that does not know where it begins is one, too.
pub(super) const MOST_SCANS: u32 = 50;
/// One that has settled is watched for this many scans before it is believed.
const LEAST_SCANS: u32 = 10;

/// What a scan did for a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Outcome {
    /// It goes on.
    Looking,
    /// The robot was found: the belief is what was found, weighed by this scan.
    Found,
    /// There is nothing better than the belief as it was.
    Nothing,
    /// Another place explains the scan as well as the belief does.
    Rival,
}

/// The search for a robot.
#[derive(Debug)]
pub struct Search {
    cloud: Cloud,
    modes: Modes,
    places: Random,
}

impl Search {
    /// None is under way.
    pub fn new(seed: u64) -> Self {
        Self { cloud: Cloud::new(seed, 4), modes: Modes::default(), places: Random::new(seed, 6) }
    }

    /// There is nothing to look for any more.
    pub fn give_up(&mut self) {
        self.cloud.clear();
    }

    /// Moves the strangers with the robot.
    pub fn move_by(&mut self, motion: &Motion) {
        self.cloud.move_by(&[*motion; 2], false);
    }

    /// Takes a scan that the belief has been weighed by.
    pub(super) fn scan(
        &mut self,
        belief: &mut Cloud,
        sensor: &mut Sensor,
        ranges_m: &[f64],
        space: &FreeSpace,
        options: &Options,
    ) -> Outcome {
        let cloud = &mut self.cloud;
        if cloud.particles.is_empty() {
            space.fill(&mut cloud.particles, options.particles as usize, &mut self.places);
            cloud.particles.level();
        }
        if !cloud.weigh(sensor, ranges_m) {
            return Outcome::Looking;
        }
        let settled = cloud.settled && cloud.scans >= LEAST_SCANS;
        if settled || cloud.scans >= MOST_SCANS {
            let of =
                |cloud: &Cloud| [cloud.beam_likelihood, cloud.seen_likelihood(sensor, ranges_m)];
            let (there, here) = (of(cloud), of(belief));
            let is_better =
                |by: f64| settled && there.iter().zip(here).all(|(there, here)| *there > by * here);
            let found = is_better(BETTER);
            let is_rival = is_better(1.0 / AS_WELL)
                && self.modes.are_apart(&cloud.particles, &belief.particles);
            if found {
                std::mem::swap(cloud, belief);
            }
            self.give_up();
            return match (found, is_rival) {
                (true, _) => Outcome::Found,
                (false, true) => Outcome::Rival,
                (false, false) => Outcome::Nothing,
            };
        }
        cloud.draw(options, false);
        Outcome::Looking
    }
}
