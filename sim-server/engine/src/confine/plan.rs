//! What the kernel can do, what was asked for, and the result: decided
//! before anybody is started, without asking the kernel twice.

use rusty_contract::{FieldError, Sandbox};
use serde::{Serialize, Serializer};

/// The Landlock ABI that all rules need: scopes of signals and abstract
/// sockets came last (Linux 6.12).
pub const ABI_NEEDED: u32 = 6;

/// What came with each ABI of Landlock that the rules use.
const CAME_WITH: [(u32, &str); 5] = [
    (1, "reading and writing files"),
    (2, "moving files between folders"),
    (3, "cutting files short"),
    (4, "TCP ports"),
    (6, "abstract sockets and signals"),
];

/// What this kernel offers to confine a process with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Kernel {
    /// The Landlock ABI; 0: there is none.
    pub landlock_abi: u32,
    /// Why there is none, as far as the kernel says.
    pub landlock: Landlock,
    /// Whether the filter of system calls is made for this processor.
    pub seccomp: bool,
}

/// Whether the kernel has Landlock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Landlock {
    /// It is there and switched on.
    Available,
    /// It is there, but was not switched on when the machine started.
    NotEnabled,
    /// This kernel was built without it or is older than 5.13, or a container
    /// refuses the call.
    NotBuilt,
}

/// How a participant is started.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Gate {
    /// Nothing was asked for.
    NotAsked,
    /// Confined with all there is to it.
    Full {
        /// The Landlock ABI of this kernel.
        abi: u32,
    },
    /// Confined with what this kernel has.
    Partial {
        /// What it lacks, in words.
        missing: String,
    },
    /// Not confined, although that was wished for.
    Down {
        /// Why not, in words.
        why: String,
    },
}

impl Gate {
    /// Whether the participant is started through `sim-server confined`.
    #[must_use]
    pub fn confines(&self) -> bool {
        matches!(self, Self::Full { .. } | Self::Partial { .. })
    }
}

impl std::fmt::Display for Gate {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NotAsked => f.write_str("no kernel gate: none was asked for"),
            Self::Full { abi } => write!(f, "kernel: landlock abi {abi} + seccomp"),
            Self::Partial { missing } => write!(f, "kernel gate partial: {missing}"),
            Self::Down { why } => write!(f, "kernel gate down: {why}"),
        }
    }
}

impl Serialize for Gate {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl Kernel {
    /// What it lacks of a full confinement; `None` if nothing.
    #[must_use]
    pub fn lacks(self) -> Option<String> {
        let mut lacks = Vec::new();
        if self.landlock_abi < ABI_NEEDED {
            let found = match self.landlock {
                Landlock::Available => format!("landlock abi {} found", self.landlock_abi),
                Landlock::NotEnabled => "landlock is not switched on".to_owned(),
                Landlock::NotBuilt => "this kernel or container offers no landlock".to_owned(),
            };
            let open: Vec<&str> = CAME_WITH
                .iter()
                .filter(|(abi, _)| *abi > self.landlock_abi)
                .map(|(_, what)| *what)
                .collect();
            lacks
                .push(format!("{found}, abi {ABI_NEEDED} needed; not closed: {}", open.join(", ")));
        }
        if !self.seccomp {
            lacks.push("no seccomp filter for this processor".to_owned());
        }
        (!lacks.is_empty()).then(|| lacks.join("; "))
    }

    /// What to do about it.
    #[must_use]
    pub fn remedy(self) -> &'static str {
        match self.landlock {
            Landlock::NotEnabled => {
                "add landlock to the kernel's `lsm=` list, or use sandbox = \"if-possible\""
            }
            _ if !self.seccomp => "use sandbox = \"if-possible\" on this processor",
            _ => "use Linux 6.12 or newer with landlock, or sandbox = \"if-possible\"",
        }
    }
}

/// Decides how a participant is started.
///
/// # Errors
/// [`FieldError`] says what is missing where a sandbox is required that cannot
/// be had: on this kernel, or because the server does not start `by_hand`
/// participants.
pub fn gate(
    field: &str,
    wanted: Sandbox,
    by_hand: bool,
    kernel: Kernel,
) -> Result<Gate, FieldError> {
    let required = wanted == Sandbox::Required;
    let refuse = |problem: String, remedy| Err(FieldError::new(field, wanted, problem, remedy));
    if wanted.is_none() {
        return Ok(Gate::NotAsked);
    }
    if by_hand {
        let why = "it is started by hand, and the server can confine only what it starts";
        let remedy = "give it a `command` and `launch` it, or use sandbox = \"if-possible\"";
        return if required {
            refuse(format!("cannot be had: {why}"), remedy)
        } else {
            Ok(Gate::Down { why: why.to_owned() })
        };
    }
    match kernel.lacks() {
        None => Ok(Gate::Full { abi: kernel.landlock_abi }),
        Some(missing) if required => refuse(format!("cannot be had: {missing}"), kernel.remedy()),
        Some(why) if kernel.landlock_abi == 0 => Ok(Gate::Down { why }),
        Some(missing) => Ok(Gate::Partial { missing }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kernel(abi: u32) -> Kernel {
        let landlock = if abi == 0 { Landlock::NotBuilt } else { Landlock::Available };
        Kernel { landlock_abi: abi, landlock, seccomp: true }
    }

    fn with(wanted: Sandbox, abi: u32) -> Result<Gate, FieldError> {
        gate("sandbox", wanted, false, kernel(abi))
    }

    #[test]
    fn a_kernel_with_everything_gives_the_full_gate() {
        for abi in [6, 7, 9] {
            for wanted in [Sandbox::IfPossible, Sandbox::Required] {
                assert_eq!(with(wanted, abi), Ok(Gate::Full { abi }));
            }
        }
        assert_eq!(Gate::Full { abi: 7 }.to_string(), "kernel: landlock abi 7 + seccomp");
        assert_eq!(with(Sandbox::None, 7), Ok(Gate::NotAsked));
    }

    #[test]
    fn required_is_refused_by_what_was_found_and_what_is_needed() {
        for abi in 0..ABI_NEEDED {
            let error = with(Sandbox::Required, abi).unwrap_err().to_string();
            assert!(error.contains("abi 6 needed") && error.contains("6.12"), "{error}");
            assert!(error.contains("abstract sockets and signals"), "{error}");
        }
        let off = Kernel { landlock: Landlock::NotEnabled, ..kernel(0) };
        let error = gate("sandbox", Sandbox::Required, false, off).unwrap_err();
        assert!(error.remedy.contains("lsm="), "{error}");
        let other = Kernel { seccomp: false, ..kernel(7) };
        let error = gate("sandbox", Sandbox::Required, false, other).unwrap_err();
        assert!(error.problem.contains("seccomp"), "{error}");
    }

    #[test]
    fn if_possible_goes_on_and_says_what_is_open() {
        let gate = with(Sandbox::IfPossible, 3).unwrap();
        assert!(gate.confines());
        let text = gate.to_string();
        assert!(text.contains("partial") && text.contains("landlock abi 3 found"), "{text}");
        assert!(text.contains("TCP") && !text.contains("cutting"), "{text}");
        let gate = with(Sandbox::IfPossible, 0).unwrap();
        assert!(!gate.confines());
        assert!(
            gate.to_string().starts_with("kernel gate down: this kernel or container offers no")
        );
    }

    #[test]
    fn what_is_started_by_hand_cannot_be_confined() {
        let by_hand = |wanted| gate("participant[0].sandbox", wanted, true, kernel(7));
        let error = by_hand(Sandbox::Required).unwrap_err().to_string();
        assert!(error.starts_with("participant[0].sandbox = required: cannot be had"), "{error}");
        assert!(error.contains("by hand") && error.contains("launch"), "{error}");
        assert!(matches!(by_hand(Sandbox::IfPossible), Ok(Gate::Down { .. })));
        assert_eq!(by_hand(Sandbox::None), Ok(Gate::NotAsked));
    }
}
