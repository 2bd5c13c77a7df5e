//! The one exchange before the first tick: a request to join, and its answer.
//!
//! Both are JSON, so that a client of another version can be refused in words
//! it understands. A `Start` holds only what the role may know; what belongs
//! to scorers and loggers alone travels in it as a sealed [`Brief`].

use rusty_geometry::{SE2, WorldSpec};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::auth::AuthKey;
use crate::config::NominalRobot;
use crate::data_sheet::{DataSheet, LidarSheet, SensorSheets};
use crate::json::{Json as _, json};
use crate::log::LogHeader;
use crate::scenario::{Access, Participant, Role};

/// Longest request the server reads, bytes.
pub const MAX_REQUEST_BYTES: usize = 4096;

/// "I am here."
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct JoinRequest {
    /// [`PROTOCOL_VERSION`](crate::PROTOCOL_VERSION) of the client.
    pub protocol: u32,
    /// [`layout_hash`](crate::layout::layout_hash) of the client.
    pub layout: u64,
    /// The name it is called in the roster.
    pub name: String,
    /// Its process, so that the kernel can tell the server of its death.
    pub pid: u32,
    /// How it waits: it looks for frames for this long before it may sleep, ns.
    pub awake_ns: u64,
    /// What it is and which version, for messages.
    pub client: String,
    /// The run that the process has taken part in to its end, where it asks for the
    /// next run of a series; 0 for its first.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub after_run: u64,
    /// Shows that it has the participant's key; see [`sign`](Self::sign).
    #[serde(default)]
    pub tag: u64,
}

json!(Brief, JoinReply, JoinRequest);

impl JoinRequest {
    /// A request by this build of the contract.
    #[must_use]
    pub fn new(name: &str, pid: u32, awake_ns: u64, client: &str) -> Self {
        Self {
            protocol: crate::PROTOCOL_VERSION,
            layout: crate::layout::layout_hash(),
            name: name.to_owned(),
            pid,
            awake_ns,
            client: client.to_owned(),
            after_run: 0,
            tag: 0,
        }
    }

    /// The same process's request for the run after `run_id`. It is not signed yet.
    #[must_use]
    pub fn after(&self, run_id: u64) -> Self {
        Self { after_run: run_id, tag: 0, ..self.clone() }
    }

    /// Signs the request with the participant's key. Nothing may be changed
    /// after it.
    pub fn sign(&mut self, key: &AuthKey) {
        self.tag = key.tag(&self.signed());
    }

    /// Whether the request was signed with this key, as it is.
    #[must_use]
    pub fn is_signed_by(&self, key: &AuthKey) -> bool {
        self.tag == key.tag(&self.signed())
    }

    /// The bytes that the tag covers: all numbers, then the texts, each with its
    /// length, then the run before, if there is one. So an old request of a process that
    /// stays for many runs gives no access to a later run.
    fn signed(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        for number in [u64::from(self.protocol), self.layout, self.pid.into(), self.awake_ns] {
            bytes.extend(number.to_le_bytes());
        }
        for text in [&self.name, &self.client] {
            bytes.extend((text.len() as u64).to_le_bytes());
            bytes.extend(text.as_bytes());
        }
        if self.after_run != 0 {
            bytes.extend(self.after_run.to_le_bytes());
        }
        bytes
    }

    /// Reads a request as it arrived. Anything may be in it.
    ///
    /// # Errors
    /// [`Refusal::Unreadable`] to send back.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, Refusal> {
        if bytes.len() > MAX_REQUEST_BYTES {
            let problem = format!("{} bytes, at most {MAX_REQUEST_BYTES}", bytes.len());
            return Err(Refusal::Unreadable(problem));
        }
        Self::from_json(bytes).map_err(|e| Refusal::Unreadable(e.to_string()))
    }
}

/// What the server says to a request.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum JoinReply {
    /// Welcome.
    Start(Box<Start>),
    /// No.
    Refused(Refusal),
}

/// All a participant is told.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Start {
    /// This run, drawn afresh at every start.
    pub run_id: u64,
    /// Name of the scenario.
    pub scenario: String,
    /// Place in the roster.
    pub participant: u32,
    /// Name in the roster.
    pub name: String,
    /// Drawn afresh for every joining: answers carry it, so that one who lost
    /// its slot, or never had it, is not taken for the one who has it.
    pub ticket: u32,
    /// For one who comes back into a run: the ticks it is given again first.
    pub catch_up: Option<CatchUp>,
    /// Role in the roster.
    pub role: Role,
    /// Whether the run waits for its answers.
    pub awaited: bool,
    /// Process of the server.
    pub server_pid: u32,
    /// How many ticks the run has.
    pub ticks: u64,
    /// Length of a tick, s.
    pub dt_s: f64,
    /// One scan every N ticks; 0: none.
    pub scan_every: u64,
    /// What the maker says of the robot.
    pub robot: NominalRobot,
    /// Whose figures of the sensors these are: the run's, the data sheets', or none.
    pub data_sheet: DataSheet,
    /// Geometry of the LiDAR, and its figures where they are told.
    pub lidar: LidarSheet,
    /// Geometry of the small sensors, and their figures where they are told.
    #[serde(default, skip_serializing_if = "SensorSheets::is_none")]
    pub sensors: SensorSheets,
    /// The walls, where they are given.
    pub map: Option<WorldSpec>,
    /// Where the robot starts, where that is given.
    pub initial_pose: Option<SE2>,
    /// How the server waits, so that a client knows when it may be asleep, ns:
    /// it yields for this long before it blocks.
    pub server_awake_ns: u64,
    /// Whether the participant compares every frame's bytes with its digest: in
    /// a run where a participant is confined, because it is not trusted.
    pub check_frames: bool,
    /// Whether the process may ask for another run after this one.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub more_runs: bool,
    /// Number of the run in its series, from 0: each has a separate key to the truth, see
    /// [`TruthKey::of_run`](crate::TruthKey::of_run).
    #[serde(default, skip_serializing_if = "is_zero")]
    pub run_number: u64,
    /// For scorers and loggers: a [`Brief`] in JSON, sealed with the key.
    pub sealed_brief: Option<Vec<u8>>,
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_zero(number: &u64) -> bool {
    *number == 0
}

impl Start {
    /// The same without what differs between the runs of a process: what depends on
    /// nothing else may be kept for the next run.
    #[must_use]
    pub fn without_run(&self) -> Self {
        Self {
            run_id: 0,
            ticket: 0,
            run_number: 0,
            ticks: 0,
            catch_up: None,
            sealed_brief: None,
            ..self.clone()
        }
    }

    /// What `participant` of a run with this header may know, on place `slot`:
    /// no brief yet, and of no server. A start travels through memory that
    /// everyone maps; so what only scorers and loggers may know, walls, initial
    /// pose and true figures of the sensors included, is left to their sealed brief.
    #[must_use]
    pub fn new(header: &LogHeader, slot: usize, participant: &Participant) -> Self {
        let config = &header.config;
        let data_sheet = header.data_sheet_of(participant);
        let (lidar, sensors) = header.sheets(data_sheet);
        let told = |access: Access| access == Access::Given && !participant.role.holds_key();
        Self {
            run_id: 0,
            scenario: config.scenario.clone(),
            participant: slot as u32,
            name: participant.name.clone(),
            ticket: 0,
            catch_up: None,
            role: participant.role,
            awaited: participant.is_awaited(),
            server_pid: 0,
            ticks: config.ticks,
            dt_s: config.dt_s,
            scan_every: config.scan_every,
            robot: config.robot.nominal(),
            data_sheet,
            lidar,
            sensors,
            map: header.known_world().filter(|_| told(participant.map)).cloned(),
            initial_pose: header.known_start().filter(|_| told(participant.initial_pose)),
            server_awake_ns: u64::MAX,
            check_frames: false,
            more_runs: false,
            run_number: 0,
            sealed_brief: None,
        }
    }
}

/// How a participant that comes back is given what it missed: the ticks from
/// the first one on, by a separate service, then those of everyone.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CatchUp {
    /// How many ticks come that way, from tick 0.
    pub ticks: u64,
    /// The service's name: frames in `<name>`, tallies in `<name>-tallies`.
    pub service: String,
}

/// What only scorers and loggers are told.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Brief {
    /// The header of this run's log: configuration, seed, roster.
    pub header: LogHeader,
    /// The folder for what they write; `None` when they should write nothing
    /// unless told otherwise on their own command line.
    pub out_dir: Option<String>,
    /// Whether a scorer also draws: the report and its pictures.
    pub report: bool,
}

/// Why a process may not take part.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, Error)]
pub enum Refusal {
    /// No participant of that name is in the roster.
    #[error("the roster has no participant {name:?}; it has: {}", roster.join(", "))]
    Unknown {
        /// The name asked for.
        name: String,
        /// The names there are.
        roster: Vec<String>,
    },
    /// Another process has that name already.
    #[error("{name:?} has joined already (process {pid}); a second one would answer twice")]
    Taken {
        /// The name asked for.
        name: String,
        /// The process that has it.
        pid: u32,
    },
    /// The request does not carry the tag of the participant's key.
    #[error(
        "process {pid} does not have the key of {name:?}: a launched participant reads it from \
         standard input (--key-stdin), one that is started by hand from {key_file}, as the user \
         who serves the run"
    )]
    Unsigned {
        /// The name asked for.
        name: String,
        /// The process that asked.
        pid: u32,
        /// Where the server left the key for a participant started by hand.
        key_file: String,
    },
    /// Another version of the protocol.
    #[error(
        "the client speaks protocol {client}, the server {server}; build both from the same version"
    )]
    Protocol {
        /// The client's.
        client: u32,
        /// The server's.
        server: u32,
    },
    /// Another layout of the wire structs.
    #[error(
        "the client was built for layout {client:016x}, the server for {server:016x}; build both \
         from the same version (`sim-server layout` prints the server's)"
    )]
    Layout {
        /// The client's.
        client: u64,
        /// The server's.
        server: u64,
    },
    /// The request could not be read.
    #[error("the request to join cannot be read: {0}")]
    Unreadable(String),
    /// The participant was lost and the run went on without it.
    #[error("{name:?} was dropped from this run ({why}); it cannot come back into it")]
    Dropped {
        /// The name asked for.
        name: String,
        /// Why it was dropped.
        why: String,
    },
    /// The run is over.
    #[error("the run has ended")]
    Ended,
    /// The series of runs is over: the reply to a process that stayed for another one.
    #[error("the series of runs has ended")]
    NoMoreRuns,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tag_of_a_request_for_the_next_run_is_for_that_run_alone() {
        let key = AuthKey::from_bytes([1; 16]);
        let mut first = JoinRequest::new("ekf", 5, 400, "test");
        first.sign(&key);
        let mut next = first.after(7);
        assert!(!next.is_signed_by(&key));
        next.sign(&key);
        assert!(next.is_signed_by(&key) && next.tag != first.tag);
        let replayed = JoinRequest { after_run: 8, ..next.clone() };
        assert!(!replayed.is_signed_by(&key));
        // A client that knows of no series sends and reads the same JSON as before.
        let json = serde_json::to_string(&first).unwrap();
        assert!(!json.contains("after_run"));
        assert_eq!(JoinRequest::from_bytes(json.as_bytes()), Ok(first));
        let json = serde_json::to_vec(&next).unwrap();
        assert_eq!(JoinRequest::from_bytes(&json), Ok(next));
    }
}
