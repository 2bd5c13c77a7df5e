//! Keys of a terminal, one by one and without waiting.

use std::os::fd::AsFd as _;

use rustix::termios::{
    LocalModes, OptionalActions, SpecialCodeIndex, Termios, isatty, tcgetattr, tcsetattr,
};

use crate::command::Command;

/// The terminal at standard input. Dropped, it is as it was.
pub(crate) struct Terminal {
    before: Termios,
}

impl Terminal {
    /// Prepares it to hand out keys as they are pressed; `None` if there is no terminal.
    pub(crate) fn open() -> Option<Self> {
        let input = std::io::stdin();
        let before = isatty(&input).then(|| tcgetattr(&input).ok()).flatten()?;
        let mut keys = before.clone();
        keys.local_modes -= LocalModes::ICANON | LocalModes::ECHO;
        keys.special_codes[SpecialCodeIndex::VMIN] = 0;
        keys.special_codes[SpecialCodeIndex::VTIME] = 0;
        tcsetattr(&input, OptionalActions::Now, &keys).ok()?;
        Some(Self { before })
    }

    /// The command of the keys that were pressed since the last call.
    pub(crate) fn command(&mut self) -> Option<Command> {
        let mut bytes = [0; 64];
        let count = rustix::io::read(std::io::stdin().as_fd(), &mut bytes).ok()?;
        command_of(&bytes[..count])
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        let _ = tcsetattr(std::io::stdin(), OptionalActions::Now, &self.before);
    }
}

/// The command of the last key that is one for driving.
fn command_of(bytes: &[u8]) -> Option<Command> {
    let command = |ahead, left| Some(Command::Parts { ahead, left });
    let of = |at: usize| match &bytes[at..] {
        [0x1B, b'[' | b'O', b'A', ..] | [b'w' | b'W', ..] => command(1.0, 0.0),
        [0x1B, b'[' | b'O', b'B', ..] | [b's' | b'S', ..] => command(-1.0, 0.0),
        [0x1B, b'[' | b'O', b'C', ..] | [b'd' | b'D', ..] => command(0.0, -1.0),
        [0x1B, b'[' | b'O', b'D', ..] | [b'a' | b'A', ..] => command(0.0, 1.0),
        [b' ', ..] => command(0.0, 0.0),
        _ => None,
    };
    let mut found = None;
    let mut at = 0;
    while at < bytes.len() {
        found = of(at).or(found);
        at += if bytes[at] == 0x1B { 3 } else { 1 };
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrows_letters_and_space_are_commands_and_the_last_one_counts() {
        for (keys, expected) in [
            (&b"\x1B[A"[..], Some((1.0, 0.0))),
            (b"s", Some((-1.0, 0.0))),
            (b"\x1BOD", Some((0.0, 1.0))),
            (b"wwwd", Some((0.0, -1.0))),
            (b"w \x1B[Z", Some((0.0, 0.0))),
            (b"\x1B[Z", None),
            (b"", None),
        ] {
            let expected = expected.map(|(ahead, left)| Command::Parts { ahead, left });
            assert_eq!(command_of(keys), expected, "{keys:?}");
        }
    }
}
