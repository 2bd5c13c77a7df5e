//! The checks: what each does to a client, what it expects, whose rule it is.

use rusty_contract::Role;
use rusty_contract::Role::{Driver, Estimator, Logger, Observer, Scorer};

use serde::Serialize;

use super::Bench;
use super::checks::{answering, disturbances, endings, joining};
use super::fault::Halt;
use super::verdict::Verdict;

/// A rule, and how the kit tests it.
#[derive(Serialize)]
pub struct Check {
    /// Its name, in kebab-case.
    #[serde(rename = "check")]
    pub name: &'static str,
    /// What is done to the client.
    pub done: &'static str,
    /// What it should do.
    pub expected: &'static str,
    /// The rule.
    pub rule: &'static str,
    /// Where the rule stands.
    pub stands_in: &'static str,
    /// Whom it is about.
    pub roles: &'static [Role],
    /// Why it is not about the others.
    #[serde(skip)]
    pub not_for: &'static str,
    #[serde(skip)]
    pub(super) looks_at_undisturbed: bool,
    #[serde(skip)]
    pub(super) make: Make,
}

type Make = fn(&Bench<'_>) -> Result<Verdict, Halt>;

const ALL: &[Role] = &[Estimator, Driver, Scorer, Logger, Observer];
const AWAITED: &[Role] = &[Estimator, Driver, Scorer, Logger];
const ANSWERING: &[Role] = &[Estimator, Driver];
const RECORDERS: &[Role] = &[Scorer, Logger];
const TOLD: &[Role] = &[Estimator, Driver, Observer];
const NOT_AWAITED: &str = "nobody waits for an observer, and what it says is no data";
const NO_NUMBERS: &str = "only estimators and drivers answer with numbers";
const BRIEFED: &str = "scorers and loggers read walls and initial pose in their sealed brief";
const PROTOCOL: &str = "rusty_contract, \"The protocol\" (shared/contract/src/lib.rs)";

const fn about_all(name: &'static str, make: Make) -> Check {
    Check {
        name,
        done: "",
        expected: "",
        rule: "",
        stands_in: PROTOCOL,
        roles: ALL,
        not_for: "",
        looks_at_undisturbed: false,
        make,
    }
}

/// For those that the server waits for, compared with undisturbed runs.
const fn about_awaited(name: &'static str, make: Make) -> Check {
    let (roles, not_for) = (AWAITED, NOT_AWAITED);
    Check { roles, not_for, looks_at_undisturbed: true, ..about_all(name, make) }
}

/// For those whose answers have numbers, compared with undisturbed runs.
const fn about_answering(name: &'static str, make: Make) -> Check {
    let (roles, not_for) = (ANSWERING, NO_NUMBERS);
    Check { roles, not_for, looks_at_undisturbed: true, ..about_all(name, make) }
}

/// For those that read the world from their Start.
const fn about_told(name: &'static str, make: Make) -> Check {
    Check { roles: TOLD, not_for: BRIEFED, ..about_all(name, make) }
}

impl std::fmt::Display for Check {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { name, done, expected, rule, stands_in, .. } = self;
        write!(f, "{name}\n  done      {done}\n  expected  {expected}\n")?;
        write!(f, "  the rule  {rule}\n  see       {stands_in}")
    }
}

/// All checks, in the order in which a client meets the rules.
pub const CATALOGUE: &[Check] = &[
    Check {
        done: "started with --run, --name and --wait",
        expected: "a request to join that tells protocol, layout, name and process",
        rule: "a client asks for its slot once, in JSON: the protocol version and layout hash it \
               was built for, the name of --name, the number of its process, how long it looks \
               for frames before it may sleep",
        stands_in: "shared/contract/src/join.rs (JoinRequest)",
        ..about_all("joins", joining::joins)
    },
    Check {
        done: "given its slot, and no frame",
        expected: "Ready (answer kind 7) and nothing before it",
        rule: "the first frame is published when everyone has said Ready; frames do not wait for \
               ports that open later",
        ..about_all("ready-before-first-frame", joining::ready_first)
    },
    Check {
        done: "24 ticks, then the end",
        expected: "one answer per tick with its run, slot, tick and digest, of a kind that fits \
                   the role",
        rule: "the answer is the acknowledgement: one per frame, carrying back run_id, tick and \
               digest; estimators estimate or abstain, a driver commands, scorers and loggers \
               say taken",
        stands_in: "shared/contract/src/answer.rs; README, What holds, 3",
        ..about_awaited("answers-every-tick", answering::every_tick)
    },
    Check {
        done: "24 ticks, then the end",
        expected: "finite numbers; a covariance symmetric, its diagonal not negative",
        rule: "an answer with a number that is none counts as no answer, and its sender as lost; \
               without an estimate, abstain",
        stands_in: "shared/contract/src/answer.rs (Reply::check)",
        ..about_answering("numbers-are-finite", answering::finite)
    },
    Check {
        done: "the same frames in two runs",
        expected: "the same answers, bit for bit",
        rule: "answers are reproducible only if the client is: no clock, no unseeded chance, no \
               order that changes",
        stands_in: "README, Limits of the promise",
        ..about_answering("deterministic", answering::deterministic)
    },
    Check {
        done: "runs with 1, 1080, empty and no scans, and with one per tick",
        expected: "answers to the end",
        rule: "a frame has a scan only if bit 0 of flags is set, with as many ranges as beams \
               says, 1 to 1080; a beam without return reports range_max_m",
        stands_in: "shared/contract/src/frame.rs; shared/contract/src/config/lidar.rs",
        ..about_all("scan-shapes", answering::scan_shapes)
    },
    Check {
        done: "no map in its Start",
        expected: "answers, or an end of its own with a message",
        rule: "a scenario may hide the map; a client that cannot work without says so and ends, \
               code not 0",
        stands_in: "shared/contract/src/join.rs (Start::map)",
        ..about_told("hidden-map", joining::hidden_map)
    },
    Check {
        done: "no initial pose in its Start",
        expected: "answers, or an end of its own with a message",
        rule: "a scenario may hide where the robot starts; a client that cannot work without says \
               so and ends, code not 0",
        stands_in: "shared/contract/src/join.rs (Start::initial_pose)",
        ..about_told("hidden-initial-pose", joining::hidden_pose)
    },
    Check {
        done: "frames long after it may sleep, some without a wake-up",
        expected: "the answers of the undisturbed run",
        rule: "frames come when they come; wake-ups are hints that may be lost, so a sleeper \
               looks at the data by itself after a bounded while",
        ..about_awaited("late-frames", disturbances::late)
    },
    Check {
        done: "three frames shown twice",
        expected: "the answers of the undisturbed run to the ticks after them",
        rule: "ticks of a run only grow: a frame whose tick was seen before is skipped; a second \
               answer to it would be counted and left, but it must not be worked in twice",
        ..about_awaited("doubled-tick", disturbances::doubled)
    },
    Check {
        done: "a frame with another run id before two ticks",
        expected: "no answer to it, and the answers of the undisturbed run",
        rule: "a frame whose run_id is not that of Start is of another run and is skipped",
        ..about_awaited("foreign-frame", disturbances::foreign)
    },
    Check {
        done: "SIGSTOP, a frame, SIGCONT",
        expected: "the answers of the undisturbed run",
        rule: "a stopped client is slow, not lost: once it goes on, it answers what waits",
        stands_in: "README, What holds, 5",
        ..about_awaited("stop-in-mid-tick", disturbances::stopped)
    },
    Check {
        done: "a frame whose bytes do not have its digest",
        expected: "a refusal: Failed (answer kind 6) or an exit code other than 0",
        rule: "who scores or logs computes the digest of a frame afresh and trusts no run whose \
               frames differ from theirs",
        stands_in: "shared/contract/src/frame.rs (the observable part)",
        roles: RECORDERS,
        not_for: "only scorers and loggers must check digests; others send back what they read",
        ..about_all("damaged-digest", disturbances::damaged)
    },
    Check {
        done: "24 ticks, then the end of the run: done",
        expected: "leave message (answer kind 5), exit code 0",
        rule: "a frame whose phase is not 0 ends the run: finish, send kind 5, end",
        ..about_all("end", endings::done)
    },
    Check {
        done: "interrupted, aborted, and aborted in mid-tick after 5 ticks",
        expected: "leave message, no more answers, exit code 0 or 3",
        rule: "phase 2 (interrupted) and 3 (aborted) end a run before its last tick; what is \
               there is kept",
        ..about_all("early-end", endings::early)
    },
    Check {
        done: "SIGTERM between two ticks",
        expected: "leave message, then its end",
        rule: "who is asked to stop sends kind 5, so that the server need not guess",
        ..about_all("sigterm", endings::sigterm)
    },
    Check {
        done: "the server killed (SIGKILL) after 5 ticks",
        expected: "an end of its own with a message, exit code not 0, nothing left behind",
        rule: "a client watches the process in Start's server_pid; if it is gone, nobody will \
               speak again: end, and sweep what the run left",
        ..about_all("dying-server", endings::dying_server)
    },
    Check {
        done: "refused",
        expected: "the server's reason in its words, exit code not 0",
        rule: "a refusal is JSON too: print the reason, do not ask again",
        stands_in: "shared/contract/src/join.rs (Refusal)",
        ..about_all("refused", joining::refused)
    },
];

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;
    use std::path::Path;

    #[test]
    fn every_check_has_a_name_of_its_own_and_says_what_it_is_about() {
        let names: BTreeSet<&str> = CATALOGUE.iter().map(|c| c.name).collect();
        assert_eq!(names.len(), CATALOGUE.len());
        for check in CATALOGUE {
            assert!(check.name.bytes().all(|b| b.is_ascii_lowercase() || b == b'-'));
            for text in [check.done, check.expected, check.rule] {
                assert!(!text.is_empty() && !text.contains("  "), "{}: {text:?}", check.name);
            }
            assert_eq!(check.not_for.is_empty(), check.roles == ALL, "{}", check.name);
        }
    }

    #[test]
    fn the_rules_stand_where_the_checks_say() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let text = |file: &str| std::fs::read_to_string(root.join(file)).unwrap();
        assert!(text("shared/contract/src/lib.rs").contains("# The protocol"));
        for check in CATALOGUE {
            for place in check.stands_in.split("; ") {
                if let Some(section) = place.strip_prefix("README, ") {
                    let section = section.split(',').next().unwrap();
                    assert!(text("README.md").contains(section), "{}: {place}", check.name);
                } else {
                    let file = place.split(['(', ' ', ')']).find(|w| w.ends_with(".rs")).unwrap();
                    assert!(root.join(file).exists(), "{}: {place}", check.name);
                }
            }
        }
    }
}
