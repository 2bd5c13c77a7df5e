//! All ticks of a log as one table.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use rusty_contract::log::TickRecord;
use rusty_contract::{Estimate, LandmarkReading, Sensors};
use rusty_geometry::SE2;

use super::error::ExportError;
use super::sheet::Sheet;
use super::walk::{Walk, truth};
use super::{Exported, Rows};

const TICK: &str = "tick,time_s,left_ticks,right_ticks,v_m_s,omega_rad_s,\
                    truth.x_m,truth.y_m,truth.theta_rad";
const OF_EACH: [&str; 6] = ["x_m", "y_m", "theta_rad", "var_x_m2", "var_y_m2", "var_theta_rad2"];

/// Writes the ticks of `log` to `out`, with `force` also over a file that is
/// there: a line each, numbers as short as they can be and still read back to
/// the same bits, nothing where there is nothing. Names of participants need no
/// quoting.
///
/// # Errors
/// [`ExportError`]; nothing is written then.
pub fn export(
    log: &Path,
    out: &Path,
    force: bool,
    stop: &AtomicBool,
) -> Result<Exported, ExportError> {
    let mut walk = Walk::open(log, stop)?;
    let mut sheet = Sheet::create(out, force)?;
    // The truth's columns are called so already.
    let owner = |n: String| if n == "truth" { "truth.estimate".to_owned() } else { n };
    let columns =
        walk.names().into_iter().map(owner).flat_map(|n| OF_EACH.map(|c| format!(",{n}.{c}")));
    let sensors = walk.header.config.sensors.clone();
    let sensors = Sensing(&sensors);
    sheet.head(format_args!("{TICK}{}{}", columns.collect::<String>(), sensors.head()))?;
    let (dt_s, mut rows) = (walk.header.config.dt_s, Rows::of(&walk));
    while let Some(record) = walk.tick()? {
        rows.see(&record, &walk);
        let mut line = of_tick(&record, dt_s) + &pose(truth(&record).as_ref());
        for estimate in walk.estimates() {
            line += &pose(estimate.as_ref().map(|e| &e.pose_in_world));
            line += &variances(estimate.as_ref());
        }
        sheet.line(format_args!("{line}{}", sensors.line(&record)))?;
    }
    Ok(rows.exported(walk, sheet.finish()?))
}

/// The columns of the small sensors that a robot has, the last of a line: doors as
/// `3;7`, landmarks as `id:range:bearing;…`, `-` where nothing was seen.
struct Sensing<'a>(&'a Sensors);

impl Sensing<'_> {
    fn head(&self) -> String {
        let Sensors { bumper, imu, sonar, doors, landmarks } = self.0;
        let sonars = sonar.as_ref().map_or(0, |sonar| sonar.mounts.len());
        let sonars = (0..sonars).map(|k| format!(",sonar_{k}_m"));
        let names = [
            (bumper.is_some(), ",bumper"),
            (imu.is_some(), ",imu.yaw_rate_rad_s,imu.accel_x_m_s2,imu.accel_y_m_s2"),
        ];
        let mut head: String = names.iter().filter(|n| n.0).map(|n| n.1).collect();
        head.extend(sonars);
        head += if doors.is_some() { ",doors" } else { "" };
        head + if landmarks.is_some() { ",landmarks" } else { "" }
    }

    fn line(&self, record: &TickRecord) -> String {
        let Sensors { bumper, imu, sonar, doors, landmarks } = self.0;
        let readings = record.readings.get();
        let number = |n: Option<f64>| n.map_or_else(|| ",".to_owned(), |n| format!(",{n:?}"));
        let mut line = String::new();
        if bumper.is_some() {
            line += &readings.bumper().map_or_else(|| ",".to_owned(), |bits| format!(",{bits}"));
        }
        if imu.is_some() {
            let read = readings.imu();
            line += &number(read.map(|imu| imu.yaw_rate_rad_s));
            line += &number(read.map(|imu| imu.accel_x_m_s2));
            line += &number(read.map(|imu| imu.accel_y_m_s2));
        }
        let ranges_m = readings.sonar_ranges_m().unwrap_or_default();
        for k in 0..sonar.as_ref().map_or(0, |sonar| sonar.mounts.len()) {
            line += &number(ranges_m.get(k).copied());
        }
        if doors.is_some() {
            line += &list(readings.doors().map(|doors| doors.iter().map(f64::to_string)));
        }
        if landmarks.is_some() {
            let text = |seen: &LandmarkReading| {
                let id = seen.id().map_or_else(|| "?".to_owned(), |id| id.to_string());
                format!("{id}:{:?}:{:?}", seen.range_m, seen.bearing_rad)
            };
            line += &list(readings.landmarks().map(|seen| seen.iter().map(text)));
        }
        line
    }
}

/// A cell: nothing where there is no reading, `-` where nothing was seen.
fn list(seen: Option<impl Iterator<Item = String>>) -> String {
    let Some(seen) = seen else { return ",".to_owned() };
    let seen = seen.collect::<Vec<_>>().join(";");
    if seen.is_empty() { ",-".to_owned() } else { format!(",{seen}") }
}

fn of_tick(record: &TickRecord, dt_s: f64) -> String {
    let (ticks, command) = (record.ticks, record.command);
    let time_s = record.time_s(dt_s);
    let (left, right) = (ticks.left, ticks.right);
    format!(
        "{},{time_s:?},{left},{right},{:?},{:?}",
        record.tick, command.v_m_s, command.omega_rad_s
    )
}

fn pose(pose: Option<&SE2>) -> String {
    pose.map_or_else(|| ",,,".to_owned(), |p| format!(",{:?},{:?},{:?}", p.x(), p.y(), p.theta()))
}

fn variances(estimate: Option<&Estimate>) -> String {
    let covariance = estimate.and_then(|e| e.covariance);
    covariance.map_or_else(|| ",,,".to_owned(), |c| format!(",{:?},{:?},{:?}", c[0], c[4], c[8]))
}
