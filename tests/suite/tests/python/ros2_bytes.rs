//! The bytes of exported messages are those that rclpy writes.

use std::collections::BTreeSet;

use mcap::MessageStream;
use rusty_contract::digest::hex;
use rusty_tests::ros::Ros;
use rusty_tests::*;

/// Messages of each topic that are compared.
const EACH: usize = 20;

#[test]
fn rclpy_reads_every_type_and_writes_the_same_bytes() {
    let Some(ros) = Ros::open() else { return };
    let place = folder();
    let sensed = sensed_scenario(place.path(), "sensed.toml", "imu = {}\n");
    launch("bytes", &place.at("run"), &[&sensed]);
    let (log, file) = (place.at("run/run.log"), place.at("run.mcap"));
    sim_server(&["export", "mcap", arg(&log), "-o", arg(&file), "--truth"]).expect(0);
    let bytes = fs::read(&file).unwrap();
    let (mut lines, mut types) = (String::new(), BTreeSet::new());
    let mut counts = std::collections::BTreeMap::<String, usize>::new();
    for message in MessageStream::new(&bytes).unwrap().map(Result::unwrap) {
        let count = counts.entry(message.channel.topic.clone()).or_default();
        *count += 1;
        let name = message.channel.schema.as_ref().unwrap().name.clone();
        // No wheels of these packages are on the registry.
        let is_known = !name.starts_with("tf2_msgs/") && !name.starts_with("visualization_msgs/");
        if is_known && *count <= EACH {
            lines += &format!("{name} {}\n", hex(&message.data));
            types.insert(name);
        }
    }
    assert!(types.len() >= 9, "{types:?}");
    let input = place.write("messages.txt", &lines);
    let mut command = ros.python();
    let output = command.arg(python::script("ros2_bytes.py")).arg(input).output();
    let output = output.unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    let said: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(said["different"], json!([]), "{said}");
    assert_eq!(said["same"], lines.lines().count());
}
