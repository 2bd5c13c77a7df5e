//! The checks themselves, by what they are about.

pub(super) mod answering;
pub(super) mod disturbances;
pub(super) mod endings;
pub(super) mod joining;

use rusty_contract::Phase;

use super::fault::Halt;
use super::player::Player;
use super::setting::{Setting, TICKS};
use super::transcript::Transcript;
use super::verdict::Verdict;
use super::{Bench, Kit};

/// What a check comes to.
type CheckResult = Result<Verdict, Halt>;

/// A whole run, `ticks` long; `tick` plays each of them.
fn play(
    kit: &Kit,
    setting: &Setting,
    ticks: u64,
    mut tick: impl FnMut(&mut Player<'_>, u64) -> Result<(), Halt>,
) -> Result<Transcript, Halt> {
    let folder = kit.folder()?;
    let mut player = Player::open(kit, setting, folder.path())?;
    let played = player
        .gather()
        .and_then(|()| (0..ticks).try_for_each(|t| tick(&mut player, t)))
        .and_then(|()| player.end(Phase::Done));
    let mut said = std::mem::take(&mut player.said);
    match played {
        Ok(()) => {}
        Err(Halt::Client(fault)) => said.fault = Some(fault),
        Err(halt) => return Err(halt),
    }
    Ok(said)
}

/// An undisturbed run.
pub(super) fn undisturbed(kit: &Kit) -> Result<Transcript, Halt> {
    play(kit, &Setting::usual(kit.role), TICKS, |player, _| player.tick())
}

/// A run that `tick` disturbs, compared with an undisturbed one.
fn disturbed(
    bench: &Bench<'_>,
    tick: impl FnMut(&mut Player<'_>, u64) -> Result<(), Halt>,
) -> Result<(Transcript, Verdict), Halt> {
    let said = play(bench.kit, &Setting::usual(bench.kit.role), TICKS, tick)?;
    let verdict = bench.compared(&said);
    Ok((said, verdict))
}

impl Bench<'_> {
    fn compared(&self, said: &Transcript) -> Verdict {
        let [first, second] = &self.undisturbed;
        if let Some(fault) = &said.fault {
            return Verdict::Fail(fault.to_string());
        }
        if first.fault.is_some() || second.fault.is_some() {
            let why = "an undisturbed run to compare with did not come to its end";
            return Verdict::NotApplicable(why.to_owned());
        }
        if second.difference(first).is_some() {
            let why = "its answers differ from run to run anyway, see deterministic";
            return Verdict::NotApplicable(why.to_owned());
        }
        match said.difference(first) {
            Some(difference) => Verdict::Fail(difference),
            None => {
                let count = said.answers.len();
                Verdict::Pass(format!("{count} answers, those of the undisturbed run"))
            }
        }
    }
}
