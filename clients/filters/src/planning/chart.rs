//! What a map says of ways, all together.

use nalgebra::Point2;

use super::routes::nearest_free;
use super::{Clearance, Room, Routes, Unknown, straighten};
use crate::OccupancyMap;

/// A robot in a place without enough room is led off it, if room is this
/// near, m.
pub(super) const LED_OFF_M: f64 = 0.5;

/// A point this far from all walls is one of something else, m.
const NEW_M: f64 = 0.2;

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

    /// The same chart with points (world frame, m) that are not to be touched either.
    pub fn with_obstacles(&self, points: impl Iterator<Item = Point2<f64>>) -> Self {
        let mut chart = self.clone();
        let within_m = self.room.liked_m.max(self.room.needed_m);
        // What lies on a known wall says nothing new, and noise would narrow every door.
        let unknown = points.filter(|point| self.clearance.at_point(*point) > NEW_M);
        unknown.for_each(|point| chart.clearance.block(point, within_m));
        chart
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

#[cfg(test)]
mod tests {
    use super::*;
    use rusty_geometry::apartment;

    #[test]
    fn a_way_leads_round_what_was_seen() {
        let map = OccupancyMap::of_world(&apartment(), 0.1, 0.05);
        let room = Room { needed_m: 0.2, liked_m: 0.5, dislike: 4.0 };
        let chart = Chart::new(&map, Unknown::Wall, room);
        let (from, to) = (Point2::new(8.6, 4.5), Point2::new(10.6, 4.5));
        let box_at = Point2::new(9.6, 4.5);
        let nearest_m = |corners: &[Point2<f64>]| {
            let near = corners.windows(2).map(|pair| {
                let along = pair[1] - pair[0];
                let share = ((box_at - pair[0]).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
                (pair[0] + along * share - box_at).norm()
            });
            near.fold(f64::INFINITY, f64::min)
        };
        assert!(nearest_m(&chart.way(from, to).unwrap()) < 0.05);
        let wall = apartment().distance_to_nearest(Point2::new(9.6, 4.5));
        assert!(wall > 0.5, "{wall}");
        let seen = chart.with_obstacles([box_at].into_iter());
        assert!(nearest_m(&seen.way(from, to).unwrap()) >= room.needed_m - 0.05);
        // A point of a known wall changes nothing.
        let same = chart.with_obstacles([Point2::new(0.0, 4.5)].into_iter());
        assert_eq!(same.clearance, chart.clearance);
    }
}
