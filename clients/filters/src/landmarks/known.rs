//! The landmarks of a given map.

use nalgebra::{Matrix2, Matrix3, Vector2};
use rusty_clients::ClientError;
use rusty_contract::{LandmarkReading, Start};
use rusty_geometry::SE2;

use super::{Candidate, Expected, LandmarkModel, LandmarkOptions, Match};

/// The landmarks of a map, and the model of their readings.
#[derive(Clone, Debug)]
pub struct KnownLandmarks {
    model: LandmarkModel,
    /// Identity and place of each landmark, world frame, m.
    map: Vec<(u32, Vector2<f64>)>,
}

impl KnownLandmarks {
    /// Returns the landmarks of the map that the participant is given.
    ///
    /// # Errors
    /// [`ClientError::Unusable`]: there is no landmark sensor, or no map with landmarks.
    pub fn of_start(start: &Start, options: &LandmarkOptions) -> Result<Self, ClientError> {
        let model = LandmarkModel::of_start(start, options)?;
        let landmarks = start.map.iter().flat_map(|map| &map.landmarks);
        let map: Vec<_> = landmarks.map(|l| (l.id, Vector2::from(l.at))).collect();
        if map.is_empty() {
            return Err(ClientError::Unusable(format!(
                "{:?} gets no map with landmarks, and localises by them: give it \
                 map = \"given\" in the scenario and landmarks in the world file, or take \
                 `ekf-slam`",
                start.name
            )));
        }
        Ok(Self { model, map })
    }

    /// Covariance R of a reading (m², rad²), diagonal.
    pub fn r(&self) -> &Matrix2<f64> {
        &self.model.r
    }

    /// Returns the reading that is expected of landmark `k`.
    pub fn expected(&self, pose_in_world: &SE2, k: usize) -> Option<Expected> {
        LandmarkModel::expected(pose_in_world, &self.map[k].1)
    }

    /// Returns the landmark of each reading (Table 7.3), seen from a pose with this covariance.
    pub fn matches(
        &self,
        pose_in_world: &SE2,
        covariance: &Matrix3<f64>,
        readings: &[LandmarkReading],
    ) -> Vec<Match> {
        let known = |id| self.map.iter().position(|landmark| landmark.0 == id);
        let candidates = |reading: &LandmarkReading, found: &mut Vec<Candidate>| {
            found.extend((0..self.map.len()).filter_map(|k| {
                let expected = self.expected(pose_in_world, k)?;
                let of = expected.innovation(reading, covariance, &self.model.r);
                Candidate::new(k, &of.nu, &of.s)
            }));
        };
        self.model.association.matches(readings, known, candidates)
    }
}
