//! What a client answers to frames as they should be.

use rusty_contract::config::sensors::{
    BumperConfig, DoorSensorConfig, ImuConfig, LandmarkSensorConfig, SonarConfig,
};
use rusty_contract::{AnswerError, LidarConfig, Reply, Role, Scenario, Sensors};

use super::{CheckResult, play};
use crate::Bench;
use crate::setting::{CLIENT_SLOT, Setting, TICKS};
use crate::transcript::Response;
use crate::verdict::Verdict;

/// How far two halves of a covariance may differ, as a part of the larger.
const ASYMMETRY: f64 = 1e-9;

pub(crate) fn every_tick(bench: &Bench<'_>) -> CheckResult {
    let said = &bench.undisturbed[0];
    if let Some(fault) = &said.fault {
        return Ok(Verdict::Fail(fault.to_string()));
    }
    if let Some(wrong) = said.answers.iter().find_map(|h| label(h, bench.kit.role)) {
        return Ok(Verdict::Fail(wrong));
    }
    if let Some(first) = said.strays.first() {
        let count = said.strays.len();
        let tick = first.answer.tick;
        return Ok(Verdict::Fail(format!("{count} more than one per tick, first to tick {tick}")));
    }
    let replies = || said.answers.iter().filter_map(Response::reply);
    if bench.kit.role == Role::Driver && replies().all(|r| r.command().is_none()) {
        return Ok(Verdict::Fail("it never gave a command, so the robot never moves".to_owned()));
    }
    let abstained = replies().filter(|r| *r == Reply::Abstain).count();
    let count = said.answers.len();
    let also = if abstained > 0 { format!(", {abstained} abstain") } else { String::new() };
    Ok(Verdict::Pass(format!("{count} answers to {TICKS} ticks{also}")))
}

/// What is wrong with the label or the kind of an answer.
fn label(received: &Response, role: Role) -> Option<String> {
    let Response { answer, message, asked: (tick, digest) } = received;
    if answer.tick != *tick {
        return Some(format!("an answer to tick {} where tick {tick} was asked", answer.tick));
    }
    if answer.participant as usize != CLIENT_SLOT {
        let slot = answer.participant;
        return Some(format!("tick {tick}: from slot {slot}; Start gave it slot {CLIENT_SLOT}"));
    }
    if answer.digest_seen != *digest {
        let seen = answer.digest_seen;
        return Some(format!("tick {tick}: digest {seen:016x}, the frame has {digest:016x}"));
    }
    if let Err(e @ AnswerError::UnknownKind(_)) = message {
        return Some(format!("tick {tick}: {e}"));
    }
    // Numbers that are none are another check's.
    let reply = received.reply()?;
    let fits = match role {
        Role::Estimator => matches!(reply, Reply::Estimate(_) | Reply::Abstain),
        Role::Driver => reply != Reply::Taken,
        Role::Scorer | Role::Logger => reply == Reply::Taken,
        Role::Observer => true,
    };
    (!fits).then(|| format!("tick {tick}: {} answered {reply:?}", role.word()))
}

pub(crate) fn finite(bench: &Bench<'_>) -> CheckResult {
    let said = &bench.undisturbed[0];
    let mut with_covariance = 0;
    for received in &said.answers {
        let tick = received.asked.0;
        if let Err(e) = &received.message {
            return Ok(Verdict::Fail(format!("tick {tick}: {e}")));
        }
        let covariance = received.reply().and_then(|r| r.estimate().and_then(|e| e.covariance));
        with_covariance += usize::from(covariance.is_some());
        if let Some((i, j, a, b)) = covariance.and_then(asymmetry) {
            return Ok(Verdict::Fail(format!(
                "tick {tick}: covariance[{i}][{j}] is {a} and covariance[{j}][{i}] is {b}"
            )));
        }
    }
    let count = said.answers.len();
    Ok(match count {
        0 => Verdict::NotApplicable("there was no answer".to_owned()),
        _ => Verdict::Pass(format!("{count} answers, {with_covariance} with a covariance")),
    })
}

/// The first pair of entries that should be equal and is not.
fn asymmetry(c: [f64; 9]) -> Option<(usize, usize, f64, f64)> {
    [(0, 1), (0, 2), (1, 2)].into_iter().find_map(|(i, j)| {
        let (a, b) = (c[3 * i + j], c[3 * j + i]);
        ((a - b).abs() > ASYMMETRY * a.abs().max(b.abs())).then_some((i, j, a, b))
    })
}

pub(crate) fn deterministic(bench: &Bench<'_>) -> CheckResult {
    let [first, second] = &bench.undisturbed;
    Ok(if let Some(difference) = second.difference(first) {
        Verdict::Fail(difference)
    } else if first.fault.is_some() || second.fault.is_some() {
        let why = "an undisturbed run did not come to its end, see answers-every-tick";
        Verdict::NotApplicable(why.to_owned())
    } else {
        Verdict::Pass(format!("{} answers twice", first.answers.len()))
    })
}

/// Ticks of a run with scans of a strange shape.
const FEW: u64 = 8;

pub(crate) fn scan_shapes(bench: &Bench<'_>) -> CheckResult {
    let usual = || Setting::usual(bench.kit.role);
    let shaped = |lidar: LidarConfig, scan_every: u64| Setting {
        scenario: Scenario { lidar, scan_every, ..usual().scenario },
        ..usual()
    };
    let lidar = LidarConfig::default();
    let sensed = || Setting {
        scenario: Scenario {
            sensors: Sensors {
                bumper: Some(BumperConfig::default()),
                imu: Some(ImuConfig::default()),
                sonar: Some(SonarConfig::default()),
                doors: Some(DoorSensorConfig::default()),
                landmarks: Some(LandmarkSensorConfig::default()),
            },
            ..usual().scenario
        },
        ..usual()
    };
    let shapes = [
        ("scans of 1 beam", shaped(LidarConfig { beams: 1, ..lidar }, 1)),
        ("scans of 1080 beams", shaped(LidarConfig { beams: 1080, ..lidar }, 3)),
        ("scans without a return", shaped(LidarConfig { dropout: 1.0, ..lidar }, 3)),
        ("no scan at all", shaped(lidar, 0)),
        ("readings of every small sensor", sensed()),
    ];
    for (shape, setting) in shapes {
        let said = play(bench.kit, &setting, FEW, |player, _| player.tick())?;
        if let Some(fault) = said.fault {
            return Ok(Verdict::Fail(format!("{shape}: {fault}")));
        }
    }
    Ok(Verdict::Pass("it took part to the end of all five".to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_covariance_is_symmetric_up_to_rounding() {
        let mut c = [1.0, 0.1, 0.2, 0.1, 2.0, 0.3, 0.2, 0.3, 3.0];
        c[1] = 0.1 + 1e-12;
        assert_eq!(asymmetry(c), None);
        c[7] = 0.31;
        assert_eq!(asymmetry(c), Some((1, 2, 0.3, 0.31)));
    }
}
