//! The small sensors in Python: the numbers are those of the log.

use std::collections::BTreeMap;

use rusty_contract::LandmarkReading;
use rusty_contract::log::LogReader;
use rusty_tests::python::python;
use rusty_tests::*;

use crate::models::says;

#[test]
fn readings_are_the_same_in_rust_and_python_tick_by_tick_and_as_rows() {
    let Some(python) = python() else { return };
    let place = folder();
    let scenario = sensed_scenario(place.path(), "all.toml", "imu = {}");
    let (_out, log) = logged("sensed", &[&scenario]);
    let said: Value = serde_json::from_str(&says(python, "sensed.py", &[arg(&log)])).unwrap();
    let records = records(&log);
    let header = LogReader::open(&log).unwrap().header().clone();
    assert_eq!(said["sensors"], serde_json::to_value(&header.config.sensors).unwrap());
    assert_eq!((&said["sheet"], &said["dropout"]), (&json!("nominal"), &json!(0.0)));
    let mut rows: BTreeMap<&str, Vec<Value>> = BTreeMap::new();
    for (record, said) in records.iter().zip(said["ticks"].as_array().unwrap()) {
        let (readings, tick) = (record.readings.get(), record.tick as f64);
        let imu = readings.imu().map(|r| [r.yaw_rate_rad_s, r.accel_x_m_s2, r.accel_y_m_s2]);
        let id = |seen: &LandmarkReading| seen.id().map_or(-1.0, f64::from);
        let landmark = |seen: &LandmarkReading| [id(seen), seen.range_m, seen.bearing_rad];
        let landmarks = readings.landmarks().map(|seen| seen.iter().map(landmark).collect());
        let landmarks: Option<Vec<[f64; 3]>> = landmarks;
        let doors = readings.doors().map(|all| all.iter().map(|d| *d as u8).collect::<Vec<_>>());
        assert_eq!(said["bumper"], json!(readings.bumper()));
        assert_eq!(said["imu"], json!(imu));
        assert_eq!(said["sonars"], json!(readings.sonar_ranges_m()));
        assert_eq!(said["doors"], json!(doors));
        assert_eq!(said["landmarks"], json!(landmarks));
        let nothing = |width: usize| vec![f64::NAN; width];
        let mut row = |name, numbers: &[f64]| {
            rows.entry(name).or_default().push(json!([&[tick], numbers].concat()));
        };
        row("bumper", &[readings.bumper().unwrap().into()]);
        row("imu", &imu.unwrap());
        readings.sonar_ranges_m().into_iter().for_each(|ranges_m| row("sonars", ranges_m));
        match readings.doors() {
            Some([]) => row("doors", &nothing(1)),
            doors => doors.into_iter().flatten().for_each(|door| row("doors", &[*door])),
        }
        match landmarks.as_deref() {
            Some([]) => row("landmarks", &nothing(3)),
            seen => seen.into_iter().flatten().for_each(|seen| row("landmarks", seen)),
        }
    }
    assert_eq!(said["rows"], json!(rows));
    assert_eq!(rows.len(), 5, "every sensor said something");
    let empty = rows["doors"].iter().filter(|row| row[1].is_null()).count();
    assert!(empty > 0, "no reading of doors is empty");
}

#[test]
fn figures_that_are_hidden_are_none_in_python() {
    let Some(python) = python() else { return };
    let place = folder();
    let scenario = sensed_scenario(place.path(), "all.toml", "imu = {}");
    let text = fs::read_to_string(&scenario).unwrap();
    fs::write(
        &scenario,
        text.replacen("name = \"dead-", "data_sheet = \"hidden\"\nname = \"dead-", 1),
    )
    .unwrap();
    let (_out, log) = logged("hidden", &[&scenario]);
    let args = [arg(&log), "dead-reckoning"];
    let said: Value = serde_json::from_str(&says(python, "sensed.py", &args)).unwrap();
    assert_eq!((&said["sheet"], &said["dropout"]), (&json!("hidden"), &Value::Null));
    assert_eq!(
        (&said["sensors"]["imu"], &said["sensors"]["sonar"]["every"]),
        (&json!({}), &json!(3))
    );
    assert!(said["sensors"]["sonar"].get("range_std_m").is_none(), "{}", said["sensors"]);
}
