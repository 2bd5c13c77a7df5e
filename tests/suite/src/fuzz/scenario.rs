//! A scenario file, and `--set` changes to it.

use std::path::PathBuf;

use rusty_contract::{Frame, Scenario, ScriptConfig};
use rusty_engine::scenario_file::{self, Loaded};
use rusty_sim::Sim;

/// Words of the format.
pub const WORDS: [&str; 16] = [
    "\n--set robot.slip_std=",
    "\n--set ",
    "[[participant]]\n",
    "[robot]\n",
    "[lidar]\n",
    "[script]\nkind = ",
    "\"driver\"",
    "nan",
    "inf",
    "1e999",
    "a.a.a.a.a.a.a.a",
    "[[[[[[[[",
    "name = \"",
    "required = false\n",
    "role = \"observer\"\n",
    "\u{e9}\u{202e}",
];

/// Lines that begin with `--set ` are changes; the others are the file.
pub fn scenario(bytes: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(bytes) else { return false };
    let (changes, file): (Vec<&str>, Vec<&str>) =
        text.lines().partition(|line| line.starts_with("--set "));
    let changes: Vec<String> =
        changes.iter().map(|line| line.trim_start_matches("--set ").to_owned()).collect();
    let Ok(scenario) = scenario_file::read(&file.join("\n"), &changes) else { return false };

    let text = toml::to_string(&scenario).expect("a scenario can be written");
    let again = Scenario::from_toml(&text).expect("what was written is read");
    assert_eq!(toml::to_string(&again).expect("again"), text);
    set_up(scenario);
    true
}

/// Sets the run up and makes some ticks, where no other file is needed.
fn set_up(scenario: Scenario) {
    let reads = matches!(&scenario.script, ScriptConfig::Commands { file: Some(_), .. });
    if scenario.world_file.is_some() || reads {
        return;
    }
    let Ok(config) = (Loaded { scenario, folder: PathBuf::new() }).config() else { return };
    let Ok(mut sim) = Sim::new(config) else { return };
    let mut frame = Frame::boxed();
    for tick in 0..3 {
        let _ = sim.step(None, &mut frame);
        assert_eq!(frame.tick(), tick);
        let (command, truth) = (frame.command(), sim.truth());
        assert!(frame.time_s().is_finite() && truth.is_finite());
        assert!(command.v_m_s.is_finite() && command.omega_rad_s.is_finite());
        let numbers = frame.ranges_m().unwrap_or_default();
        assert!(numbers.iter().all(|r| r.is_finite() && *r >= 0.0), "{numbers:?}");
    }
}
