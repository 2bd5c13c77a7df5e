//! The header of the run log: the configuration that fits a recording, and the
//! remarks that say what of it is known, assumed or left out.

use std::f64::consts::PI;
use std::path::Path;

use rusty_contract::config::{LidarConfig, RobotConfig, RunConfig, ScriptConfig};
use rusty_contract::log::{Finding, LogHeader, Source};
use rusty_contract::{OnLoss, Scenario};
use rusty_geometry::world_spec::MAX_NAME_CHARS;
use rusty_geometry::{SE2, WorldSpec, tick_length};

use super::NOMINAL_RATE_HZ;
use super::error::ImportError;
use super::findings::findings;
use super::ranges::RangeMax;
use super::report::ImportReport;
use super::survey::{Drive, Survey, Told};
use super::wheels::{Mount, WHEELS};

/// Room around the path of the robot, m.
const MARGIN_M: f64 = 10.0;
/// Spread of a range, m: the class of a SICK LMS 200. No log says it.
const RANGE_STD_M: f64 = 0.01;

const START_BY_TRUTH: &str =
    "the start is set so that dead reckoning meets the corrected pose at the first scan";
const START_BY_ODOMETRY: &str = "the start is the first pose of the odometry";
const NO_LIDAR: &str = "the LiDAR's configuration is a placeholder";

/// Everything that is said about a recording.
pub(super) struct Plan {
    pub(super) header: LogHeader,
    pub(super) report: ImportReport,
    /// Ticks are numbered, for the stamps stand still.
    pub(super) numbered: bool,
}

/// Makes header and report, and checks the configuration.
pub(super) fn plan(
    input: &Path,
    writer: &str,
    survey: &Survey,
    drive: &Drive,
) -> Result<Plan, ImportError> {
    let (remarks, findings) = (remarks(survey, drive), findings(survey, drive));
    let stem = stem(input);
    let config = RunConfig {
        scenario: stem.clone(),
        seed: 0,
        ticks: survey.tick_count(),
        dt_s: dt_s(survey),
        scan_every: 0,
        start: drive.start,
        robot: robot(),
        lidar: lidar(survey),
        script: ScriptConfig::Commands { file: None, list: Vec::new() },
        world: world(stem, drive.around_m),
        sensors: rusty_contract::Sensors::default(),
        kidnappings: Vec::new(),
        walkers: Vec::new(),
        crowd: None,
        events: Vec::new(),
        fleet: None,
        patches: Vec::new(),
    };
    config.check().map_err(|error| ImportError::file(input, error))?;
    let file = input.file_name().unwrap_or_default();
    let header = LogHeader {
        writer: writer.to_owned(),
        source: Source::Recorded {
            format: survey.told.as_ref().map_or("carmen", |told| told.format).to_owned(),
            file: file.to_string_lossy().into_owned(),
            remarks: remarks.clone(),
            findings: findings.clone(),
        },
        config,
        roster: Scenario::usual_participants(),
        on_loss: OnLoss::Abort,
    };
    let report = report(survey, drive, &header.config, remarks, findings);
    Ok(Plan { header, report, numbered: survey.flat.is_some() })
}

/// The file's name without `.gz` and without its last extension, short enough
/// for a world's name.
fn stem(input: &Path) -> String {
    let name = input.file_name().unwrap_or_default().to_string_lossy();
    let name = name.strip_suffix(".gz").unwrap_or(&name);
    let stem = Path::new(name).file_stem().unwrap_or_default();
    let stem = stem.to_string_lossy();
    let clean = stem.chars().filter(|c| !c.is_control());
    let short: String = clean.take(MAX_NAME_CHARS).collect();
    if short.is_empty() { "recording".to_owned() } else { short }
}

/// Mean time between ticks, within what a configuration allows. It is only
/// informative where every tick carries its own stamp; where stamps stand still,
/// it is the time between ticks.
fn dt_s(survey: &Survey) -> f64 {
    let intervals = survey.tick_count().saturating_sub(1);
    let mean_s = (survey.last_stamp_s - survey.first_stamp_s) / intervals as f64;
    if mean_s.is_finite() && mean_s > 0.0 {
        mean_s.clamp(1e-6, 10.0)
    } else {
        1.0 / NOMINAL_RATE_HZ
    }
}

fn robot() -> RobotConfig {
    RobotConfig {
        wheel_radius_m: WHEELS.wheel_radius_m,
        track_m: WHEELS.track_m,
        body_radius_m: 0.5 * WHEELS.track_m,
        ticks_per_rev: WHEELS.ticks_per_rev,
        wheel_limit_rad_s: 1000.0,
        slip_std: 0.0,
        slip_std_left: None,
        slip_std_right: None,
        slip_outlier_rate: 0.0,
        slip_outlier_factor: 10.0,
        radius_bias_right: 0.0,
        track_bias: 0.0,
    }
}

/// Beams from −90° over 180°. 181 and 361 beams have one at +90°, other
/// numbers stop a step before it.
fn lidar(survey: &Survey) -> LidarConfig {
    if let Some(lidar) = survey.told.as_ref().and_then(|told| told.lidar) {
        return lidar;
    }
    let beams = survey.beams.max(1);
    let fov_rad = match beams {
        181 | 361 => PI * beams as f64 / (beams - 1) as f64,
        _ => PI,
    };
    LidarConfig {
        beams: beams as u32,
        first_bearing_rad: -0.5 * PI,
        fov_rad,
        range_max_m: survey.ranges.max().m,
        range_std_m: RANGE_STD_M,
        sensor_in_body: SE2::new(survey.mount().offset_m, 0.0, 0.0),
        ..LidarConfig::default()
    }
}

/// No walls: a recording does not say where they are.
fn world(name: String, around_m: [f64; 4]) -> WorldSpec {
    let [x_min, y_min, x_max, y_max] = around_m;
    let bounds = [x_min - MARGIN_M, y_min - MARGIN_M, x_max + MARGIN_M, y_max + MARGIN_M];
    WorldSpec { name, bounds, walls: Vec::new(), landmarks: Vec::new() }
}

fn report(
    survey: &Survey,
    drive: &Drive,
    config: &RunConfig,
    remarks: Vec<String>,
    findings: Vec<Finding>,
) -> ImportReport {
    let wheels = &drive.wheels;
    let (first_stamp_s, last_stamp_s) = match survey.flat {
        None => (survey.first_stamp_s, survey.last_stamp_s),
        Some(_) => (config.dt_s, survey.tick_count() as f64 * config.dt_s),
    };
    ImportReport {
        lines: survey.lines,
        readings: survey.readings,
        scans: survey.scans,
        scans_with_odometry: survey.scans_with_odometry,
        anchors: survey.anchors,
        detached: survey.detached,
        ticks: survey.tick_count(),
        beams: survey.beams as u32,
        dt_s: config.dt_s,
        first_stamp_s,
        last_stamp_s,
        stamps_backwards: survey.stamps_backwards,
        backwards_max_s: survey.backwards.value,
        backwards_max_line: survey.backwards.line,
        lateral_max_m: wheels.lateral.value,
        lateral_max_line: wheels.lateral.line,
        lateral_total_m: wheels.lateral_total_m,
        step_max_m: wheels.step.value,
        step_max_line: wheels.step.line,
        distance_m: wheels.distance_m,
        end_error_m: drive.end_error_m,
        skipped: survey.skipped.clone(),
        wheel: WHEELS,
        remarks,
        findings,
    }
}

/// What a reader should know of the conversion, a sentence each.
fn remarks(survey: &Survey, drive: &Drive) -> Vec<String> {
    if let Some(told) = &survey.told {
        return ros_remarks(told, survey, drive);
    }
    let mut list = vec![counts_remark(), sideways_remark(drive)];
    if survey.anchors > 0 {
        list.push(format!(
            "{} of {} scans are echoed by an ODOM line with the corrected pose: these lines are \
             no readings, the odometry is the chain of increments between them",
            survey.anchors - survey.detached,
            survey.scans
        ));
    }
    if survey.detached > 0 {
        list.push(format!(
            "{} further ODOM lines belong to scans that are not here, or to scans whose echo is \
             not: the odometry goes on from their poses, and they are no readings either",
            survey.detached
        ));
    }
    list.push("the commands are unknown; every frame says zero".to_owned());
    list.push(stamps_remark(survey));
    if survey.scans == 0 {
        list.push("no scans (FLASER), hence no true pose anywhere".to_owned());
        list.push(START_BY_ODOMETRY.to_owned());
        list.push(NO_LIDAR.to_owned());
    } else {
        list.push(truth_remark(survey, drive));
        list.push(START_BY_TRUTH.to_owned());
        list.push(lidar_remark(survey, drive));
        list.extend(mount_remark(survey.mount(), survey.arm_m()));
    }
    list.push("no walls are known; the bounds are the path and 10 m around it".to_owned());
    if !survey.skipped.is_empty() {
        let types: Vec<&str> = survey.skipped.keys().map(String::as_str).collect();
        list.push(format!("messages that were not read: {}", types.join(", ")));
    }
    list
}

fn ros_remarks(told: &Told, survey: &Survey, drive: &Drive) -> Vec<String> {
    let mut list = vec![counts_remark(), sideways_remark(drive)];
    list.extend(told.remarks.iter().cloned());
    list.push("lines are the messages of the recording, counted from 1".to_owned());
    list.push("the commands are unknown; every frame says zero".to_owned());
    list.push(stamps_remark(survey));
    let by_truth = drive.end_error_m.is_some();
    list.push(if by_truth { START_BY_TRUTH } else { START_BY_ODOMETRY }.to_owned());
    if told.lidar.is_none() {
        list.push(NO_LIDAR.to_owned());
    }
    list.push("no walls are known; the bounds are the path and 10 m around it".to_owned());
    if !survey.skipped.is_empty() {
        let topics: Vec<&str> = survey.skipped.keys().take(64).map(String::as_str).collect();
        list.push(format!("topics that were not read: {}", topics.join(", ")));
    }
    list
}

fn counts_remark() -> String {
    format!(
        "the encoder counts are those of virtual wheels (radius {} m, track {} m, {} counts per \
         revolution, {:.2} µm each) that drive the increments of the log's odometry",
        WHEELS.wheel_radius_m,
        WHEELS.track_m,
        WHEELS.ticks_per_rev,
        1e6 * tick_length(&WHEELS)
    )
}

fn sideways_remark(drive: &Drive) -> String {
    let wheels = &drive.wheels;
    format!(
        "two wheels cannot move sideways: that part of the increments is dropped, at most {:.2} \
         mm{}, {:.2} m in all over {:.1} m driven",
        1e3 * wheels.lateral.value,
        at_line(wheels.lateral.line),
        wheels.lateral_total_m,
        wheels.distance_m
    )
}

/// Where it was, if it was anywhere.
fn at_line(line: u64) -> String {
    if line == 0 { String::new() } else { format!(" (line {line})") }
}

fn stamps_remark(survey: &Survey) -> String {
    if survey.flat.is_some() {
        return format!(
            "the log's stamps stand still: ticks are numbered in file order at {NOMINAL_RATE_HZ} Hz"
        );
    }
    let which = match survey.told {
        None => "the one before the host's name",
        Some(_) => "those of the headers",
    };
    let mut text = format!("stamps are the log's own ({which}), ticks stand in file order");
    if survey.stamps_backwards > 0 {
        text += &format!(
            "; {} stamps are earlier than the one before, by at most {:.6} s (line {})",
            survey.stamps_backwards, survey.backwards.value, survey.backwards.line
        );
    }
    if survey.two_times > 0 {
        text += &format!("; in {} lines the logger's stamp differs", survey.two_times);
    }
    text
}

fn truth_remark(survey: &Survey, drive: &Drive) -> String {
    let known = "true poses are the first pose of each scan's line, and known at scans only";
    let (far_m, line) = (drive.correction.value, drive.correction.line);
    if survey.anchors > 0 {
        return format!("{known}; a SLAM back end computed them, nobody measured them");
    }
    format!(
        "{known}; nothing in the log says that a SLAM back end corrected them: from the odometry \
         they are at most {far_m:.3} m away{}",
        at_line(line)
    )
}

fn lidar_remark(survey: &Survey, drive: &Drive) -> String {
    let RangeMax { m: max_m, known_from, .. } = survey.ranges.max();
    let [nothing, all] = drive.nothing;
    format!(
        "beams are taken to lie from -90 degrees over 180; ranges from {max_m} m on ({known_from}) \
         mean that nothing came back ({nothing} of {all}) and stand as they were; the spread of \
         a range, {RANGE_STD_M} m, is assumed"
    )
}

/// How an offset of the laser was understood; nothing if there is none.
fn mount_remark(mount: Mount, arm_m: Option<f64>) -> Option<String> {
    if mount.offset_m == 0.0 {
        return None;
    }
    let odometry = match (mount.odometry_is_laser, arm_m) {
        (true, Some(m)) => format!(
            "the odometry's poses move like a point at x = {m:.3} m and are taken for \
             the laser's"
        ),
        (_, Some(m)) => format!(
            "the odometry's poses move like a point at x = {m:.3} m and are taken for \
             the robot's"
        ),
        (_, None) => "the odometry's poses are taken for the robot's".to_owned(),
    };
    let scans = if mount.scans_are_laser { "the laser's" } else { "the robot's" };
    Some(format!(
        "the laser sits at x = {} m on the robot (robot_frontlaser_offset); {odometry}, those of the \
         scans for {scans}; ticks and truth are the robot's",
        mount.offset_m
    ))
}
