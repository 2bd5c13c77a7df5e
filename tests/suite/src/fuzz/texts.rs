//! Short texts: keys, names, paces, ways to wait, lists of commands.

use rusty_contract::config::parse_commands;
use rusty_contract::names::{MAX_PARTICIPANT_NAME, MAX_RUN_NAME, check_participant_name};
use rusty_contract::{Credentials, RunName, TruthKey};
use rusty_engine::run::Pace;
use rusty_link::WaitPolicy;

/// Words of the formats.
pub const WORDS: [&str; 14] = [
    "max",
    "real",
    "balanced",
    "1e-320",
    "1e308",
    "nan",
    "inf",
    "+f",
    "-",
    "_",
    " 18446744073709551615\n",
    "0 0 1000000\n",
    "# ",
    "\u{e9}",
];

/// The same text put to each of them.
pub fn texts(bytes: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(bytes) else { return false };
    let taken = [key(text), run_name(text), participant_name(text), pace(text), commands(text)];
    let wait = text.parse::<WaitPolicy>().inspect(|w| assert_eq!(w.to_string(), text)).is_ok();
    wait || credentials(text) || taken.contains(&true)
}

fn key(text: &str) -> bool {
    let Ok(key) = TruthKey::from_hex(text) else { return false };
    assert_eq!(key.to_hex(), text.trim().to_lowercase(), "a key has one text");
    true
}

fn credentials(text: &str) -> bool {
    let Ok(told) = Credentials::from_text(text) else { return false };
    let again = Credentials::from_text(&told.to_text()).expect("what was written is read");
    assert_eq!(again.participant, told.participant);
    true
}

fn run_name(text: &str) -> bool {
    let Ok(name) = RunName::new(text) else { return false };
    assert!(name.as_str() == text && text.len() <= MAX_RUN_NAME);
    assert!(!text.contains(['/', '.', '\0']), "it becomes part of a path");
    true
}

fn participant_name(text: &str) -> bool {
    let taken = check_participant_name(text).is_ok();
    assert!(!taken || (text.is_ascii() && text.len() <= MAX_PARTICIPANT_NAME));
    taken
}

fn pace(text: &str) -> bool {
    let Ok(pace) = text.parse::<Pace>() else { return false };
    let due: Vec<_> = [0, 1, 1 << 40, u64::MAX].map(|tick| pace.due(tick, 10.0)).into();
    assert!(due.is_sorted(), "{due:?}");
    true
}

fn commands(text: &str) -> bool {
    let Ok(list) = parse_commands("a.txt", text) else { return false };
    assert!(list.len() <= 1_000_000);
    assert!(list.iter().all(|c| c.v_m_s.is_finite() && c.omega_rad_s.is_finite()));
    !list.is_empty()
}
