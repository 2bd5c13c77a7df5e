//! Definitions of the types as text, as files of MCAP carry them (`ros2msg`).

use std::collections::BTreeSet;

/// Every definition, those of types within types included, without comments.
const DEFINITIONS: &str = include_str!("definitions.msg");
/// The line between two definitions.
const RULE: &str =
    "================================================================================\n";

/// Returns the definition of a type such as `sensor_msgs/msg/LaserScan`, followed by
/// those of the types within it; empty for a type that is not known here.
#[must_use]
pub fn schema(name: &str) -> String {
    let name = name.replace("/msg/", "/");
    let mut text = definition(&name).to_owned();
    let mut seen = BTreeSet::from([name.as_str()]);
    let mut next: Vec<&str> = within(definition(&name)).collect();
    while let Some(name) = (!next.is_empty()).then(|| next.remove(0)) {
        if seen.contains(name) {
            continue;
        }
        seen.insert(name);
        text += &format!("{RULE}MSG: {name}\n{}", definition(name));
        next.extend(within(definition(name)));
    }
    text
}

/// The lines of a type; none for one that is not known.
fn definition(name: &str) -> &'static str {
    let mut all = DEFINITIONS.split(RULE).filter_map(|part| part.strip_prefix("MSG: "));
    all.find_map(|part| part.strip_prefix(name)?.strip_prefix('\n')).unwrap_or_default()
}

/// The types of the fields that are types of ROS.
fn within(definition: &'static str) -> impl Iterator<Item = &'static str> {
    let of_line = |line: &'static str| line.split([' ', '[']).next();
    definition.lines().filter_map(of_line).filter(|name| name.contains('/'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_schema_has_each_type_within_once() {
        let text = schema("nav_msgs/msg/Odometry");
        assert!(text.starts_with("std_msgs/Header header\nstring child_frame_id\n"));
        let of = |name: &str| text.matches(&format!("{RULE}MSG: {name}\n")).count();
        let deep = ["builtin_interfaces/Time", "geometry_msgs/Quaternion", "geometry_msgs/Vector3"];
        assert_eq!(deep.map(of), [1; 3]);
        assert_eq!((of("nav_msgs/Odometry"), of("sensor_msgs/LaserScan")), (0, 0));
        assert_eq!(schema("my_msgs/msg/Own"), "");
    }

    #[test]
    fn every_type_within_a_type_is_defined() {
        for part in DEFINITIONS.split(RULE).filter_map(|part| part.strip_prefix("MSG: ")) {
            for name in within(part.split_once('\n').unwrap().1) {
                assert!(!definition(name).is_empty(), "{name} in {part}");
            }
        }
    }
}
