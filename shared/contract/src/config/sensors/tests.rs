//! Every field of every sensor is checked, and an absent sensor leaves no trace.

use super::*;

fn all() -> Sensors {
    Sensors {
        bumper: Some(BumperConfig::default()),
        imu: Some(ImuConfig::default()),
        sonar: Some(SonarConfig::default()),
        doors: Some(DoorSensorConfig::default()),
        landmarks: Some(LandmarkSensorConfig::default()),
    }
}

#[test]
fn every_number_has_a_range_and_its_error_names_the_field() {
    assert!(all().check().is_ok() && Sensors::default().check().is_ok());
    let whole = toml::Value::try_from(all()).unwrap();
    let mut fields = 0;
    for (sensor, table) in whole.as_table().unwrap() {
        for (field, value) in table.as_table().unwrap() {
            for wrong in [-1e30, 1e30, f64::NAN] {
                let wrong = match value {
                    toml::Value::Float(_) => toml::Value::Float(wrong),
                    toml::Value::Integer(_) if wrong > 0.0 => toml::Value::Integer((1 << 31) + 1),
                    toml::Value::Integer(_) => toml::Value::Integer(0),
                    _ => continue,
                };
                let mut changed = whole.clone();
                changed[sensor][field] = wrong.clone();
                let sensors: Sensors = changed.try_into().unwrap();
                let every_is_long = field == "every" && wrong.as_integer() != Some(0);
                match sensors.check() {
                    Ok(()) => assert!(every_is_long, "{sensor}.{field} = {wrong}"),
                    Err(error) => assert_eq!(error.field, format!("sensors.{sensor}.{field}")),
                }
                fields += 1;
            }
        }
    }
    assert!(fields > 60, "{fields}");
}

#[test]
fn a_sonar_has_one_to_sixteen_mounts_within_reach() {
    let mount = rusty_geometry::SE2::identity();
    for mounts in [vec![], vec![mount; 17], vec![rusty_geometry::SE2::new(1e9, 0.0, 0.0)]] {
        assert!(SonarConfig { mounts, ..SonarConfig::default() }.check().is_err());
    }
    assert!(SonarConfig { mounts: vec![mount; 16], ..SonarConfig::default() }.check().is_ok());
}

#[test]
fn an_absent_sensor_is_not_written() {
    assert_eq!(serde_json::to_string(&Sensors::default()).unwrap(), "{}");
    let text = serde_json::to_string(&all()).unwrap();
    assert_eq!(serde_json::from_str::<Sensors>(&text).unwrap(), all());
    assert_eq!(toml::from_str::<Sensors>("imu = {}").unwrap().imu, Some(ImuConfig::default()));
}
