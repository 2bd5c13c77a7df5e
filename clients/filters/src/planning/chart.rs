//! What a map says of ways, all together.

use nalgebra::Point2;

use super::routes::nearest_free;
use super::{Clearance, Room, Routes, Unknown, straighten};
use crate::OccupancyMap;

/// A robot in a place without enough room is led off it, if room is this
/// near, m.
pub(super) const LED_OFF_M: f64 = 0.5;

/// A map as one who looks for ways sees it.
#[derive(Clone, Debug)]
pub struct Chart {
    /// How far walls are.
    pub clearance: Clearance,
    /// How far they should be.
    pub room: Room,
}

impl Chart {
    /// Over a map, for a body that needs this room.
    pub fn new(map: &OccupancyMap, unknown: Unknown, room: Room) -> Self {
        Self { clearance: Clearance::of_map(map, unknown), room }
    }

    /// All ways from a point, or from the nearest place with enough room; `None`
    /// where there is none.
    pub fn routes_from(&self, from: Point2<f64>) -> Option<Routes> {
        let start = nearest_free(&self.clearance, &self.room, from, LED_OFF_M)?;
        Some(Routes::new(&self.clearance, &self.room, start))
    }

    /// Corners of the way to a cell; none where there is no way.
    pub fn corners(&self, routes: &Routes, to: usize) -> Vec<Point2<f64>> {
        straighten(&self.clearance, &self.room, &routes.cells_to(to))
    }

    /// Corners of the way from one point to another; `None` where there is none.
    pub fn way(&self, from: Point2<f64>, to: Point2<f64>) -> Option<Vec<Point2<f64>>> {
        let goal = nearest_free(&self.clearance, &self.room, to, self.clearance.frame.cell_m)?;
        let corners = self.corners(&self.routes_from(from)?, goal);
        (!corners.is_empty()).then_some(corners)
    }
}
