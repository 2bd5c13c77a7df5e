//! Landmarks that were seen too seldom to be in the map.
//!
//! Source: *Probabilistic Robotics*, §10.3.3, the provisional landmark list: a new
//! landmark does not correct the pose until it was seen often enough.
//!
//! Departures: a provisional landmark is not in the state. Its place is that of its newest
//! reading, with the covariance of a separate measurement. It is forgotten when it was not
//! seen for some time, also where a wall may have hidden it.

use nalgebra::{Matrix2, Matrix3, Vector2};

use crate::landmarks::{Association, Candidate, Match, Placed};

/// A provisional landmark that is not seen in this number of looks is forgotten.
const FORGOTTEN: u64 = 20;

#[derive(Clone, Copy, Debug, PartialEq)]
struct Seen {
    at: Vector2<f64>,
    covariance: Matrix2<f64>,
    sightings: u32,
    look: u64,
}

/// The provisional landmarks.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Provisional {
    seen: Vec<Seen>,
    look: u64,
}

impl Provisional {
    /// Begins the readings of a tick, and forgets what was not seen for long.
    pub fn begin_look(&mut self) {
        self.look += 1;
        self.seen.retain(|seen| seen.look + FORGOTTEN >= self.look);
    }

    /// Takes a reading of a landmark that is not in the map, from a pose with this
    /// covariance. Returns whether the landmark was seen `sightings` times: then it is no
    /// longer provisional.
    pub fn see(
        &mut self,
        placed: &Placed,
        pose: &Matrix3<f64>,
        association: &Association,
        sightings: u32,
    ) -> bool {
        let covariance = placed.by_pose * pose * placed.by_pose.transpose() + placed.covariance;
        let others = self.seen.iter().enumerate().filter(|(_, seen)| seen.look < self.look);
        let candidates: Vec<Candidate> = others
            .filter_map(|(k, seen)| {
                Candidate::new(k, &(placed.at - seen.at), &(seen.covariance + covariance))
            })
            .collect();
        let before = match association.choose(&candidates).0 {
            Match::Refused => return false,
            Match::New => 0,
            Match::Landmark(k) => self.seen.swap_remove(k).sightings,
        };
        if before + 1 >= sightings {
            return true;
        }
        self.seen.push(Seen { at: placed.at, covariance, sightings: before + 1, look: self.look });
        false
    }
}
