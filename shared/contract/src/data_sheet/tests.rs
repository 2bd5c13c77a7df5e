//! Each data sheet tells its figures and no others.

use super::*;
use crate::blind::{Told, blind_header};
use crate::log::Source;
use crate::{LogHeader, Participant, Role, Scenario, Start};

/// A scenario in which no figure is that of a data sheet.
fn scenario() -> Scenario {
    let text = "[lidar]\nbeams = 90\nrange_max_m = 6.5\nrange_std_m = 0.0701\n\
        range_std_per_m = 0.0702\ndropout = 0.0703\nglass_visible_rad = 0.0704\n\
        divergence_rad = 0.0705\n\
        [sensors.imu]\ngyro_noise_deg_sqrt_h = 0.0706\ngyro_bias_instability_deg_h = 0.0707\n\
        gyro_turn_on_bias_deg_h = 0.0708\naccel_noise_ug_sqrt_hz = 0.0709\n\
        accel_bias_instability_ug = 0.0710\naccel_turn_on_bias_ug = 0.0711\n\
        bias_time_s = 0.0712\n\
        [sensors.sonar]\nevery = 3\nrange_std_m = 0.0713\ndropout = 0.0714\n\
        [sensors.doors]\nevery = 4\nhit_rate = 0.0715\nfalse_alarm_rate = 0.0716\n\
        [sensors.landmarks]\nfov_rad = 3.0\nrange_std_m = 0.0717\n\
        bearing_std_rad = 0.0718\ndropout = 0.0719\n[sensors.bumper]\nsectors = 7\n";
    Scenario::from_toml(text).unwrap()
}

fn header() -> LogHeader {
    LogHeader::simulated("test", &scenario(), rusty_geometry::open().spec().clone())
}

fn blinded(header: &LogHeader) -> LogHeader {
    blind_header(header, Told::of(header), (String::new(), 0), "test")
}

/// What a participant with this role and data sheet is told, and its JSON.
fn told(header: &LogHeader, role: Role, data_sheet: DataSheet) -> (Start, String) {
    let participant = Participant { data_sheet, ..Participant::new("a", role) };
    let start = Start::new(header, 0, &participant);
    let json = serde_json::to_string(&start).unwrap();
    assert_eq!(serde_json::from_str::<Start>(&json).unwrap(), start);
    (start, json)
}

#[test]
fn given_are_the_true_figures() {
    let (start, json) = told(&header(), Role::Driver, DataSheet::Given);
    assert_eq!(start.data_sheet, DataSheet::Given);
    for figure in 701..720 {
        let text = format!("0.{figure:04}").trim_end_matches('0').to_owned();
        assert!(json.contains(&text), "{text} is not in {json}");
    }
    let scenario = scenario();
    assert_eq!(start.lidar.believed(&LidarConfig::default()), scenario.lidar);
    assert_eq!(start.sensors.believed(), scenario.sensors);
}

#[test]
fn nominal_are_the_figures_of_the_sheets_and_the_true_geometry() {
    let (start, json) = told(&header(), Role::Estimator, DataSheet::Nominal);
    assert!(!json.contains("0.07"), "{json}");
    let nominal = LidarConfig { beams: 90, range_max_m: 6.5, ..LidarConfig::default() };
    assert_eq!(start.lidar, nominal.into());
    let sensors = Sensors {
        bumper: Some(BumperConfig { sectors: 7, ..BumperConfig::default() }),
        imu: Some(ImuConfig::default()),
        sonar: Some(SonarConfig { every: 3, ..SonarConfig::default() }),
        doors: Some(DoorSensorConfig { every: 4, ..DoorSensorConfig::default() }),
        landmarks: Some(LandmarkSensorConfig { fov_rad: 3.0, ..LandmarkSensorConfig::default() }),
    };
    assert_eq!(start.sensors, SensorSheets::new(&sensors, DataSheet::Given));
}

#[test]
fn hidden_is_every_figure_and_no_geometry() {
    for role in [Role::Estimator, Role::Observer] {
        let (start, json) = told(&header(), role, DataSheet::Hidden);
        for word in ["std", "dropout", "noise", "rate\"", "glass", "bias_time", "divergence"] {
            assert!(!json.contains(word), "{word} is in {json}");
        }
        assert_eq!((start.lidar.beams, start.lidar.range_max_m), (90, 6.5));
        assert_eq!((start.lidar.range_std_m, start.lidar.dropout), (None, None));
        let sonar = start.sensors.sonar.unwrap();
        assert_eq!((sonar.every, sonar.mounts.len(), sonar.range_std_m), (3, 1, None));
        assert_eq!(start.sensors.imu.unwrap().bias_time_s, None);
        let assumed = LidarConfig { dropout: 0.25, beams: 1, ..LidarConfig::default() };
        let believed = start.lidar.believed(&assumed);
        assert_eq!((believed.dropout, believed.beams), (0.25, 90));
    }
}

#[test]
fn who_holds_the_key_has_the_figures_in_its_brief_only() {
    for role in [Role::Scorer, Role::Logger] {
        let (start, json) = told(&header(), role, DataSheet::Given);
        assert_eq!(start.data_sheet, DataSheet::Hidden);
        assert!(!json.contains("0.07"), "{json}");
    }
}

#[test]
fn a_log_from_before_data_sheets_told_the_true_figures() {
    let json = serde_json::to_string(&header()).unwrap();
    let written: LogHeader = serde_json::from_str(&json).unwrap();
    assert_eq!(written, header());
    assert_eq!(written.roster[0].data_sheet, DataSheet::Nominal);
    let before = json.replace(",\"data_sheet\":\"nominal\"", "");
    assert!(!before.contains("data_sheet"), "{before}");
    let before: LogHeader = serde_json::from_str(&before).unwrap();
    assert!(before.roster.iter().all(|p| p.data_sheet == DataSheet::Given));
    let start = Start::new(&before, 0, &before.roster[0]);
    assert_eq!(start.lidar, scenario().lidar.into());
}

#[test]
fn of_a_recording_the_figures_of_the_log_are_the_nominal_ones() {
    let source = Source::Recorded {
        format: String::new(),
        file: String::new(),
        remarks: Vec::new(),
        findings: Vec::new(),
    };
    let header = LogHeader { source, ..header() };
    let blind = blinded(&header);
    for header in [header, blind] {
        let (start, _) = told(&header, Role::Estimator, DataSheet::Nominal);
        assert_eq!(start.lidar, scenario().lidar.into());
        assert_eq!(start.sensors.believed(), scenario().sensors);
    }
}

#[test]
fn a_blind_log_has_the_true_figures_only_if_someone_was_told_them() {
    let mut header = header();
    let blind = blinded(&header);
    assert!(!serde_json::to_string(&blind).unwrap().contains("0.07"), "{blind:?}");
    for sheet in [DataSheet::Given, DataSheet::Hidden] {
        let (start, _) = told(&blind, Role::Estimator, sheet);
        assert_eq!((start.data_sheet, start.lidar.dropout), (DataSheet::Hidden, None));
    }
    header.roster[0].data_sheet = DataSheet::Given;
    let blind = blinded(&header);
    for sheet in [DataSheet::Given, DataSheet::Nominal, DataSheet::Hidden] {
        let [sealed, open] = [&blind, &header].map(|h| told(h, Role::Estimator, sheet).0);
        assert_eq!(sealed.lidar, open.lidar, "{sheet}");
        assert_eq!(sealed.sensors, open.sensors, "{sheet}");
    }
}

#[test]
fn a_word_that_is_no_data_sheet_is_refused_with_the_words_that_are() {
    let text = "[[participant]]\nname = \"a\"\ndata_sheet = \"secret\"";
    let error = Scenario::from_toml(text).unwrap_err().to_string();
    for word in ["line 3", "secret", "given", "nominal", "hidden"] {
        assert!(error.contains(word), "{word}: {error}");
        assert_eq!("secret".parse::<DataSheet>().unwrap_err().contains(word), word != "line 3");
    }
    for sheet in [DataSheet::Given, DataSheet::Nominal, DataSheet::Hidden] {
        assert_eq!(sheet.to_string().parse(), Ok(sheet));
        let text = text.replace("secret", sheet.word());
        assert_eq!(Scenario::from_toml(&text).unwrap().participants[0].data_sheet, sheet);
    }
}
