//! Ticks in, messages out: the topics of a tick and what is in them.

use rusty_contract::config::sensors::{ImuConfig, SonarConfig};
use rusty_contract::readings::Present;
use rusty_contract::{LogHeader, Scenario};

use super::*;
use crate::messages::{MarkerArray, OccupancyGrid};
use crate::{RosMessage, from_cdr};

fn header() -> LogHeader {
    let mut scenario = Scenario::default();
    scenario.sensors.imu = Some(ImuConfig::default());
    let mounts = vec![SE2::new(0.1, 0.0, 0.0), SE2::new(0.0, 0.1, 1.0)];
    scenario.sensors.sonar = Some(SonarConfig { mounts, ..SonarConfig::default() });
    LogHeader::simulated("test", &scenario, rusty_geometry::apartment().spec().clone())
}

/// The messages of a tick, owned: topic and bytes.
fn messages(encoder: &mut Encoder, tick: &Tick<'_>) -> Vec<(String, Vec<u8>)> {
    let names: Vec<String> = encoder.channels().iter().map(|c| c.topic.clone()).collect();
    let encoded = encoder.tick(tick).unwrap();
    encoded.map(|m| (names[m.channel].clone(), m.cdr.to_vec())).collect()
}

fn find<M: serde::de::DeserializeOwned>(all: &[(String, Vec<u8>)], topic: &str) -> M {
    from_cdr(&all.iter().find(|(name, _)| name == topic).unwrap().1).unwrap()
}

fn tick(counts: i64) -> Tick<'static> {
    Tick {
        time_s: 0.02,
        counts: EncoderCounts { left: counts, right: counts },
        command: Twist { v_m_s: 0.5, omega_rad_s: 0.25 },
        ranges_m: None,
        readings: Readings::new(Present::default(), &[]),
        truth: None,
        estimates: &[],
    }
}

#[test]
fn latched_messages_come_in_the_first_tick_and_when_they_are_asked_for() {
    let mut encoder = Encoder::new(Description::of(&header()));
    let topics = |all: &[(String, Vec<u8>)]| -> Vec<String> {
        all.iter().map(|(topic, _)| topic.clone()).collect()
    };
    let first = messages(&mut encoder, &tick(0));
    let latched = ["/tf_static", "/map", "/markers"];
    let every = ["/clock", "/tf", "/odom", "/cmd_vel"];
    assert_eq!(topics(&first), [&every[..1], &latched, &every[1..]].concat());
    assert_eq!(topics(&messages(&mut encoder, &tick(0))), every);
    assert_eq!(encoder.latched(1.0).unwrap().len(), 3);
    let frames: TfMessage = find(&first, "/tf_static");
    let names: Vec<_> = frames.transforms.iter().map(|t| t.child_frame_id.to_string()).collect();
    assert_eq!(names, ["laser", "imu", "sonar_0", "sonar_1"]);
    assert_eq!(find::<OccupancyGrid>(&first, "/map").info.resolution, 0.05);
    assert!(!find::<MarkerArray>(&first, "/markers").markers.is_empty());
    for channel in encoder.channels() {
        assert!(channel.schema().lines().count() > 1, "{}", channel.topic);
        assert_eq!(channel.is_latched, latched.contains(&&*channel.topic));
        assert!(
            channel
                .qos()
                .contains(["durability: 2", "durability: 1"][usize::from(channel.is_latched)])
        );
    }
    encoder.select(|channel| channel.topic == "/odom");
    assert_eq!(topics(&messages(&mut encoder, &tick(0))), ["/odom"]);
    assert_eq!(encoder.latched(1.0).unwrap().len(), 0);
}

#[test]
fn a_scan_is_ranges_and_points() {
    let mut about = Description::of(&header());
    (about.lidar.beams, about.lidar.range_max_m) = (4, 8.0);
    let mut encoder = Encoder::new(about);
    let ranges_m = [1.1, 8.0, 2.5, 7.999_999_999];
    let tick = Tick { ranges_m: Some(&ranges_m), ..tick(0) };
    let all = messages(&mut encoder, &tick);
    let scan: LaserScan = find(&all, "/scan");
    assert_eq!(scan.ranges, [1.1f32, f32::INFINITY, 2.5, 8.0]);
    let pi = std::f32::consts::PI;
    assert_eq!([scan.angle_min, scan.angle_max, scan.angle_increment], [-pi, 0.5 * pi, 0.5 * pi]);
    assert_eq!((scan.scan_time, &*scan.header.frame_id), (0.1, "laser"));
    let points: PointCloud2 = find(&all, "/scan_points");
    assert_eq!((points.width, points.data.len()), (3, 36));
    let number = |k: usize| f32::from_le_bytes(points.data[4 * k..4 * k + 4].try_into().unwrap());
    assert_eq!([number(0), number(3), number(4)], [-1.1, 2.5, 0.0]);
}

#[test]
fn odometry_and_estimate_meet_in_the_frames() {
    let mut encoder = Encoder::new(Description::of(&header()));
    let start = header().config.start;
    let frames = |all: &[(String, Vec<u8>)]| {
        let frames: TfMessage = find(all, "/tf");
        frames.transforms.iter().map(|t| SE2::from(t.transform)).collect::<Vec<SE2>>()
    };
    // Before the first estimate the start is known.
    let found = frames(&messages(&mut encoder, &tick(0)));
    assert!(found[1].boxminus(&start).norm() < 1e-12);
    let at = SE2::new(3.0, 2.0, std::f64::consts::FRAC_PI_2);
    let covariance = [4.0, 0.0, 0.5, 0.0, 1.0, 0.0, 0.5, 0.0, 0.25];
    let estimates = [Some(Estimate::new(at).with_covariance(covariance))];
    let mut next = Tick { time_s: 0.04, estimates: &estimates, ..tick(4096) };
    let all = messages(&mut encoder, &next);
    let found = frames(&all);
    // One turn of both wheels.
    let way_m = std::f64::consts::TAU * 0.033;
    assert!(found[0].boxminus(&SE2::new(way_m, 0.0, 0.0)).norm() < 1e-12);
    assert!((found[1] * found[0]).boxminus(&at).norm() < 1e-12);
    let odometry: Odometry = find(&all, "/odom");
    assert!((odometry.twist.twist.linear.x - way_m / 0.02).abs() < 1e-9);
    let pose: PoseWithCovarianceStamped = find(&all, "/dead_reckoning/pose");
    // Ahead of the body is north.
    let c = pose.pose.covariance;
    let expected = [1.0, 4.0, 0.25, 0.0, 0.5];
    for (found, expected) in [c[0], c[7], c[35], c[5], c[11]].iter().zip(expected) {
        assert!((found - expected).abs() < 1e-12, "{c:?}");
    }
    // Without an estimate the last one holds.
    (next.time_s, next.estimates) = (0.06, &[None]);
    let held = frames(&messages(&mut encoder, &next));
    assert_eq!(held[1], found[1]);
    let mut about = Description::of(&header());
    about.localizer = None;
    assert_eq!(frames(&messages(&mut Encoder::new(about), &next)).len(), 1);
}

#[test]
fn small_sensors_and_truth_have_topics_where_they_exist() {
    let about = Description { truth: true, ..Description::of(&header()) };
    let present = Present { imu: true, sonars: Some(2), ..Present::default() };
    let readings = Readings::new(present, &[0.25, 1.0, -1.0, 2.5, 10.7]);
    let truth = Some(SE2::new(1.0, 2.0, 0.0));
    let mut encoder = Encoder::new(about);
    let all = messages(&mut encoder, &Tick { readings, truth, ..tick(0) });
    let imu: Imu = find(&all, "/imu");
    assert_eq!((imu.angular_velocity.z, imu.linear_acceleration.y), (0.25, -1.0));
    let ranges = ["/sonar_0", "/sonar_1"].map(|topic| find::<Range>(&all, topic).range);
    assert_eq!(ranges, [2.5, f32::INFINITY]);
    assert_eq!(find::<PoseStamped>(&all, "/truth/pose").pose.position.y, 2.0);
    let plain = LogHeader::simulated(
        "t",
        &Scenario::default(),
        rusty_geometry::places::open().spec().clone(),
    );
    let topics: Vec<String> =
        Encoder::new(Description::of(&plain)).channels().iter().map(|c| c.topic.clone()).collect();
    for absent in ["/imu", "/sonar_0", "/truth/pose"] {
        assert!(!topics.iter().any(|topic| topic == absent));
    }
}

#[test]
fn no_type_is_without_a_schema() {
    assert!(!crate::schema::schema(crate::messages::Twist::NAME).is_empty());
}

#[test]
fn ticks_without_messages_move_the_odometry_and_the_last_one_can_be_had_later() {
    let at = |k: i64| Tick { time_s: 0.02 * k as f64, ..tick(k * k) };
    let of = |silent: bool| {
        let mut encoder = Encoder::new(Description::of(&header()));
        for k in 1..5 {
            match silent {
                true => encoder.advance(at(k).time_s, at(k).counts),
                false => drop(messages(&mut encoder, &at(k))),
            }
        }
        (messages(&mut encoder, &at(5)), encoder)
    };
    let ((all, mut encoder), (after_silence, _)) = (of(false), of(true));
    let odometry: Odometry = find(&all, "/odom");
    assert!(odometry.twist.twist.linear.x > 0.0);
    encoder.select(|channel| !channel.is_latched);
    let later: Vec<Vec<u8>> = encoder.messages(&at(5)).unwrap().map(|m| m.cdr.to_vec()).collect();
    assert_eq!(later, all.iter().map(|(_, bytes)| bytes.clone()).collect::<Vec<_>>());
    assert_eq!(after_silence, all);
}
