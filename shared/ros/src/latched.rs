//! Messages that are sent once: map, markers, and the frames of the sensors.

use rusty_geometry::{Landmark, Material, SE2, Wall, WallSpec, WorldSpec};

use crate::description::Description;
use crate::messages::{
    ColorRgba, Header, MapMetaData, Marker, MarkerArray, OccupancyGrid, Point, Pose, Text,
    TfMessage, Time, TransformStamped, Vector3,
};

/// Frame of the world.
pub const MAP: &str = "map";
/// Frame in which dead reckoning moves.
pub const ODOM: &str = "odom";
/// Frame of the body.
pub const BASE: &str = "base_link";
/// Frame of the LiDAR.
pub const LASER: &str = "laser";
/// Frame of the IMU: that of the body.
pub const IMU: &str = "imu";

/// Side of a cell of the map, m.
pub const CELL_M: f64 = 0.05;
/// Most cells of a map.
const MOST_CELLS: f64 = 4_194_304.0;
/// A free cell, and one with a wall.
const CELL: [i8; 2] = [0, 100];
/// [`Marker::shape`].
const LINE_LIST: i32 = 5;
/// [`Marker::shape`].
const SPHERE_LIST: i32 = 7;
/// Width of a wall, m.
const WALL_M: f64 = 0.03;
/// Diameter of a landmark, m.
const LANDMARK_M: f64 = 0.15;

/// Returns the header of a message.
#[must_use]
pub fn header(stamp: Time, frame: &'static str) -> Header {
    Header { stamp, frame_id: Text::Borrowed(frame) }
}

/// Returns the pose of a frame in its parent.
#[must_use]
pub fn transform(
    stamp: Time,
    parent: &'static str,
    child: impl Into<Text>,
    pose: SE2,
) -> TransformStamped {
    TransformStamped {
        header: header(stamp, parent),
        child_frame_id: child.into(),
        transform: pose.into(),
    }
}

/// Returns the frames of the sensors on the body.
#[must_use]
pub fn static_frames(about: &Description, stamp: Time) -> TfMessage {
    let mut transforms = vec![transform(stamp, BASE, LASER, about.lidar.sensor_in_body)];
    if about.sensors.imu.is_some() {
        transforms.push(transform(stamp, BASE, IMU, SE2::identity()));
    }
    let mounts = about.sensors.sonar.iter().flat_map(|sonar| sonar.mounts.iter().enumerate());
    transforms.extend(mounts.map(|(k, mount)| transform(stamp, BASE, sonar_frame(k), *mount)));
    TfMessage { transforms }
}

/// Returns the frame of a sonar.
#[must_use]
pub fn sonar_frame(k: usize) -> String {
    format!("sonar_{k}")
}

/// Returns the walls as a map: a cell with a piece of wall in it is occupied, every other
/// cell within the bounds is free. Cells are 5 cm wide, and as often twice as wide as it
/// takes for the map to have at most 4 million.
#[must_use]
pub fn map(world: &WorldSpec, stamp: Time) -> OccupancyGrid {
    let [x_min, y_min, x_max, y_max] = world.bounds;
    let size = |cell_m: f64| [x_max - x_min, y_max - y_min].map(|m| (m / cell_m).ceil() + 2.0);
    let mut cell_m = CELL_M;
    while size(cell_m)[0] * size(cell_m)[1] > MOST_CELLS {
        cell_m *= 2.0;
    }
    // A cell more on each side: walls stand on the bounds.
    let origin = [x_min - cell_m, y_min - cell_m];
    let [width, height] = size(cell_m).map(|cells| cells as usize);
    let mut data = vec![CELL[0]; width * height];
    for point in world.walls.iter().flat_map(|wall| Wall::from(wall).points(0.1 * cell_m)) {
        let column = ((point.x - origin[0]) / cell_m).floor() as usize;
        let row = ((point.y - origin[1]) / cell_m).floor() as usize;
        if let (true, Some(cell)) = (column < width, data.get_mut(row * width + column)) {
            *cell = CELL[1];
        }
    }
    let info = MapMetaData {
        map_load_time: stamp,
        resolution: cell_m as f32,
        width: width as u32,
        height: height as u32,
        origin: Pose { position: point(origin), ..Pose::default() },
    };
    OccupancyGrid { header: header(stamp, MAP), info, data }
}

/// Returns walls and landmarks as shapes, a list of lines for each material.
#[must_use]
pub fn markers(world: &WorldSpec, stamp: Time) -> MarkerArray {
    let ends = |wall: &WallSpec| [point(wall.a), point(wall.b)];
    let walls = |group: &'static str, color: [f32; 3], of: fn(Material) -> bool| {
        let walls = world.walls.iter().filter(|wall| of(wall.material));
        marker(group, (LINE_LIST, WALL_M), color, walls.flat_map(ends).collect())
    };
    let at = |landmark: &Landmark| point(landmark.at);
    let landmarks = world.landmarks.iter().map(at).collect();
    let mut markers = vec![
        walls("walls", [0.35, 0.35, 0.38], |m| m == Material::Wall),
        walls("glass", [0.35, 0.7, 0.85], |m| m == Material::Glass),
        walls("doors", [0.7, 0.45, 0.2], |m| matches!(m, Material::Door(_))),
        marker("landmarks", (SPHERE_LIST, LANDMARK_M), [0.85, 0.55, 0.1], landmarks),
    ];
    markers.retain(|marker| !marker.points.is_empty());
    for (id, marker) in (0..).zip(&mut markers) {
        (marker.header, marker.id) = (header(stamp, MAP), id);
    }
    MarkerArray { markers }
}

fn marker(
    group: &'static str,
    (shape, size_m): (i32, f64),
    [r, g, b]: [f32; 3],
    points: Vec<Point>,
) -> Marker {
    Marker {
        ns: Text::Borrowed(group),
        shape,
        scale: Vector3 { x: size_m, y: size_m, z: size_m },
        color: ColorRgba { r, g, b, a: 1.0 },
        points,
        ..Marker::default()
    }
}

fn point([x, y]: [f64; 2]) -> Point {
    Point { x, y, z: 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_map_has_the_walls_where_they_are() {
        let world = rusty_geometry::apartment();
        let map = map(world.spec(), Time::default());
        let (width, origin) = (map.info.width as usize, map.info.origin.position);
        assert_eq!(map.data.len(), width * map.info.height as usize);
        for (cell, found) in map.data.iter().enumerate() {
            let centre = |k: usize, from_m: f64| from_m + (k as f64 + 0.5) * CELL_M;
            let at = [centre(cell % width, origin.x), centre(cell / width, origin.y)];
            let distance_m = world.distance_to_nearest(at.into());
            assert!(distance_m <= 0.0354 || *found == 0, "{at:?}: {distance_m} m from a wall");
            assert!(distance_m > 0.024 || *found == 100, "{at:?}: {distance_m} m from a wall");
        }
    }

    #[test]
    fn a_large_world_has_large_cells() {
        let mut world = rusty_geometry::apartment().spec().clone();
        world.bounds = [-1000.0, -1000.0, 1000.0, 1000.0];
        let map = map(&world, Time::default());
        assert!(map.data.len() <= MOST_CELLS as usize && map.info.resolution == 1.6);
        assert!(map.data.contains(&100));
    }

    #[test]
    fn markers_have_each_wall_and_landmark() {
        let mut world = rusty_geometry::apartment().spec().clone();
        world.landmarks = vec![Landmark { id: 3, at: [1.0, 2.0] }];
        let markers = markers(&world, Time::default()).markers;
        let points = |shape| {
            let of = markers.iter().filter(move |m| m.shape == shape);
            of.map(|m| m.points.len()).sum::<usize>()
        };
        assert_eq!(points(LINE_LIST), 2 * world.walls.len());
        assert_eq!(points(SPHERE_LIST), 1);
    }
}
