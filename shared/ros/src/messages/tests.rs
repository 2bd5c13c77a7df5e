//! Messages as bytes, and back.

use serde::de::DeserializeOwned;

use super::*;
use crate::{RosMessage, from_cdr};

/// Each type with the bytes of a message, as rclpy 9.1.2 (Kilted, Fast DDS) writes
/// them, and rosbags 0.11 the two that rclpy's package registry lacks (`tf2_msgs`,
/// `visualization_msgs`). Padding, which Fast DDS leaves as it was in memory, is 0.
const GOLDEN: &str = include_str!("golden.txt");

fn check<M: RosMessage + DeserializeOwned + PartialEq + std::fmt::Debug>(message: &M) {
    let golden = GOLDEN.lines().find_map(|line| line.strip_prefix(M::NAME)?.strip_prefix(' '));
    let golden = golden.unwrap();
    let bytes = message.to_cdr().unwrap();
    let hex: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
    assert_eq!(hex, golden, "{}", M::NAME);
    assert_eq!(from_cdr::<M>(&bytes).unwrap(), *message);
    for end in 0..bytes.len() {
        assert!(from_cdr::<M>(&bytes[..end]).is_err(), "{} of {end} bytes", M::NAME);
    }
}

const STAMP: Time = Time { sec: 7, nanosec: 500_000_000 };

fn header(frame: &'static str) -> Header {
    Header { stamp: STAMP, frame_id: frame.into() }
}

fn pose() -> Pose {
    Pose {
        position: Point { x: 1.0, y: -2.0, z: 0.0 },
        orientation: Quaternion { x: 0.0, y: 0.0, z: 0.6, w: 0.8 },
    }
}

fn with_covariance() -> PoseWithCovariance {
    PoseWithCovariance { pose: pose(), covariance: std::array::from_fn(|k| k as f64) }
}

fn twist() -> Twist {
    rusty_geometry::Twist { v_m_s: 0.5, omega_rad_s: -0.25 }.into()
}

#[test]
fn sensors_are_written_as_ros_does() {
    check(&Clock { clock: STAMP });
    check(&LaserScan {
        header: header("laser"),
        angle_min: -1.5,
        angle_max: 1.5,
        angle_increment: 1.0,
        scan_time: 0.25,
        range_max: 8.0,
        ranges: vec![1.5, f32::INFINITY, 3.25],
        ..LaserScan::default()
    });
    let field = |(k, name): (u32, &'static str)| PointField {
        name: name.into(),
        offset: 4 * k,
        datatype: FLOAT32,
        count: 1,
    };
    check(&PointCloud2 {
        header: header("laser"),
        height: 1,
        width: 1,
        fields: (0..).zip(["x", "y", "z"]).map(field).collect(),
        is_bigendian: false,
        point_step: 12,
        row_step: 12,
        data: [1.0f32, 2.0, 0.0].iter().flat_map(|m| m.to_le_bytes()).collect(),
        is_dense: true,
    });
    let mut imu = Imu { header: header("imu"), ..Imu::default() };
    imu.orientation_covariance[0] = -1.0;
    imu.angular_velocity.z = 0.25;
    (imu.linear_acceleration.x, imu.linear_acceleration.z) = (1.0, 9.5);
    check(&imu);
    check(&Range {
        header: header("sonar_0"),
        radiation_type: 1,
        field_of_view: 0.5,
        min_range: 0.25,
        max_range: 10.5,
        range: 2.5,
        variance: 0.125,
    });
}

#[test]
fn poses_and_maps_are_written_as_ros_does() {
    check(&Odometry {
        header: header("odom"),
        child_frame_id: "base_link".into(),
        pose: with_covariance(),
        twist: TwistWithCovariance { twist: twist(), covariance: [0.5; 36] },
    });
    let position = Point { x: -1.0, ..Point::default() };
    let origin = Pose { position, ..Pose::default() };
    check(&OccupancyGrid {
        header: header("map"),
        info: MapMetaData { map_load_time: STAMP, resolution: 0.05, width: 3, height: 1, origin },
        data: vec![0, 100, -1],
    });
    check(&PoseStamped { header: header("map"), pose: pose() });
    check(&PoseWithCovarianceStamped { header: header("map"), pose: with_covariance() });
    check(&twist());
    check(&TwistStamped { header: header("base_link"), twist: twist() });
    let frame = |parent, child: &'static str| TransformStamped {
        header: header(parent),
        child_frame_id: child.into(),
        transform: Transform {
            translation: Vector3 { x: 1.0, y: -2.0, z: 0.0 },
            rotation: pose().orientation,
        },
    };
    check(&TfMessage { transforms: vec![frame("odom", "base_link"), frame("map", "odom")] });
    check(&MarkerArray {
        markers: vec![Marker {
            header: header("map"),
            ns: "walls".into(),
            id: 3,
            shape: 5,
            scale: Vector3 { x: 0.5, y: 0.5, z: 0.5 },
            color: ColorRgba { r: 0.25, g: 0.5, b: 0.75, a: 1.0 },
            frame_locked: true,
            points: vec![Point { x: 1.0, y: 2.0, z: 0.0 }, Point { x: 3.0, y: 4.0, z: 0.0 }],
            text: "a".into(),
            ..Marker::default()
        }],
    });
}

#[test]
fn the_other_byte_order_is_read_and_other_encodings_are_refused() {
    let big = [0, 0, 0, 0, 0, 0, 0, 7, 0x1d, 0xcd, 0x65, 0];
    assert_eq!(from_cdr::<Clock>(&big).unwrap(), Clock { clock: STAMP });
    let mut xcdr2 = Clock { clock: STAMP }.to_cdr().unwrap();
    xcdr2[1] = 7;
    assert!(matches!(from_cdr::<Clock>(&xcdr2), Err(crate::CdrError::Encoding(_))));
}

#[test]
fn a_length_that_is_not_there_takes_no_memory() {
    let mut bytes = OccupancyGrid::default().to_cdr().unwrap();
    let end = bytes.len();
    bytes[end - 4..].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(from_cdr::<OccupancyGrid>(&bytes).is_err());
}

#[test]
fn times_and_poses_of_the_plane_come_back() {
    assert_eq!(Time::from_ns(1_300_000_000).seconds(), 1.3);
    assert_eq!(Time::from_ns(u64::MAX).sec, i32::MAX);
    let flat = rusty_geometry::SE2::new(1.0, -2.0, 3.0);
    for back in [Pose::from(flat).into(), rusty_geometry::SE2::from(Transform::from(flat))] {
        let back: rusty_geometry::SE2 = back;
        assert!(back.boxminus(&flat).norm() < 1e-15);
    }
}
