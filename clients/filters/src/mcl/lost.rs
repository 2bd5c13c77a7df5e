//! What the filter does while it does not know where the robot is, or doubts it.

use super::mode::Mode;
use super::recovery::Recovery;
use super::search::{self, Outcome};
use super::{LOST, Mcl, hypotheses, known_walls};

impl Mcl {
    /// Counts the beams that end on known walls. A robot that went on without them may be
    /// elsewhere.
    pub(super) fn look_for_walls(&mut self, mode: &Mode) {
        self.known_walls.update(self.sensor.on_walls(&mode.pose_in_world));
        if self.is_found
            && self.known_walls.is_strayed()
            && let Some(places) = &mut self.hypotheses
        {
            places.clear();
            self.is_found = false;
        }
    }

    /// Looks a scan up everywhere. Returns whether the robot was found; the belief is then
    /// around that place.
    pub(super) fn compare_places(&mut self, ranges_m: &[f64]) -> bool {
        let Some(hypotheses) = &mut self.hypotheses else { return false };
        if !hypotheses.is_new_place() {
            return false;
        }
        let here = self.modes.heaviest(&self.belief.particles);
        let pose_in_world = here.map(|mode| mode.pose_in_world);
        hypotheses.take(&self.sensor.fits(ranges_m, &self.space, pose_in_world));
        let Some(found) = hypotheses.decided(pose_in_world) else { return false };
        let is_elsewhere = |mode: &Mode| !mode.is_at(&found);
        let share_here =
            here.filter(is_elsewhere).map(|mode| self.sensor.on_walls(&mode.pose_in_world));
        if !known_walls::is_found(self.sensor.on_walls(&found), share_here) {
            return false;
        }
        hypotheses.clear();
        self.is_found = true;
        if here.is_none_or(|mode| is_elsewhere(&mode)) {
            let (most, places) = (self.options.particles as usize, &mut self.places);
            self.belief.clear();
            let particles = &mut self.belief.particles;
            particles.push_normal(&found, &hypotheses::covariance(), most, places);
            particles.level();
            self.belief.weigh(&mut self.sensor, ranges_m);
        }
        if self.recovery.share() > LOST {
            self.recovery = Recovery::trusting();
            self.recovery.update(self.belief.beam_likelihood);
        }
        true
    }

    /// Looks for the robot with particles from everywhere.
    pub(super) fn look_elsewhere(&mut self, ranges_m: &[f64]) {
        let Self { belief, search, sensor, space, options, .. } = self;
        if !belief.settled && belief.scans < search::MOST_SCANS {
            return;
        }
        let outcome = search.scan(belief, sensor, ranges_m, space, options);
        match outcome {
            Outcome::Looking | Outcome::Rival => {}
            Outcome::Found => {
                self.recovery.found(belief.beam_likelihood);
                // Another place may only resemble that of the robot: all places are compared
                // before the next answer.
                let found = self.modes.heaviest(&belief.particles);
                let is_at = |before: &Mode| found.is_some_and(|f| before.is_at(&f.pose_in_world));
                self.is_found &= self.mode.as_ref().is_some_and(is_at);
            }
            Outcome::Nothing => {
                let places = self.hypotheses.as_ref().zip(self.mode.as_ref());
                if !places.is_some_and(|(places, here)| places.deny(here)) {
                    self.recovery.allay();
                }
            }
        }
        if outcome != Outcome::Looking {
            self.is_contested = outcome == Outcome::Rival;
        }
    }
}
