//! The one exchange before the first tick: request, reply, sealed brief.

use rusty_contract::{Brief, JoinReply, JoinRequest, OnLoss, Participant, Role, TruthKey};
use rusty_engine::lockstep::Lockstep;
use rusty_geometry::World;

use super::answers::rules;

/// Words of the format.
pub const WORDS: [&str; 16] = [
    "null",
    "true",
    "{}",
    "[]",
    "1e999",
    "-1",
    "18446744073709551616",
    "\"\\ud800\"",
    "\"\\u0000\"",
    "\"name\":",
    "\"pid\":",
    "\"Start\":",
    "\"Refused\":",
    "\"sealed_brief\":",
    "[[[[[[[[[[[[[[[[",
    "{\"a\":{\"a\":{\"a\":",
];

/// A request as the server reads it, and the slot it gets.
pub fn request(bytes: &[u8]) -> bool {
    let read = JoinRequest::from_bytes(bytes);
    let request = match &read {
        Ok(request) => request,
        Err(refusal) => {
            said_again(&JoinReply::Refused(refusal.clone()));
            return false;
        }
    };
    let json = serde_json::to_vec(request).expect("a request can be written");
    assert_eq!(&serde_json::from_slice::<JoinRequest>(&json).expect("again"), request);
    let roster = [Participant::new("a", Role::Estimator), Participant::new("log", Role::Logger)];
    let mut machine = Lockstep::new(rules(3, OnLoss::Continue), &roster, 0);
    match machine.join(request, 0) {
        Ok(slot) => {
            assert_eq!(machine.slots()[slot].name, request.name);
            assert!(machine.join(request, 0).is_err(), "a slot is given once");
        }
        Err(refusal) => said_again(&JoinReply::Refused(refusal)),
    }
    true
}

fn said_again(reply: &JoinReply) {
    let json = serde_json::to_vec(reply).expect("a reply can be written");
    let again: JoinReply = serde_json::from_slice(&json).expect("what was written is read");
    assert_eq!(serde_json::to_vec(&again).expect("again"), json);
}

/// A reply as a client reads it.
pub fn reply(bytes: &[u8]) -> bool {
    let Ok(reply) = serde_json::from_slice::<JoinReply>(bytes) else { return false };
    said_again(&reply);
    match reply {
        JoinReply::Refused(refusal) => assert!(!refusal.to_string().is_empty()),
        JoinReply::Start(start) => {
            if let Some(map) = start.map {
                let checked = map.check().is_ok();
                assert_eq!(World::new(map).is_ok(), checked);
            }
        }
    }
    true
}

/// A sealed brief as a scorer opens it: the bytes as they came, and as the text
/// behind a good seal.
pub fn brief(bytes: &[u8]) -> bool {
    let key = TruthKey::from_bytes([7; 32]);
    assert!(key.open_brief(1, bytes).is_err(), "sixteen bytes of digest were guessed");
    let sealed = key.seal_brief(1, bytes);
    assert_eq!(key.open_brief(1, &sealed).expect("its own seal"), bytes);
    assert!(key.open_brief(2, &sealed).is_err());
    let Ok(brief) = serde_json::from_slice::<Brief>(bytes) else { return false };
    let json = serde_json::to_vec(&brief).expect("a brief can be written");
    assert_eq!(serde_json::from_slice::<Brief>(&json).expect("again"), brief);
    brief.header.check().is_ok()
}
