//! Who may see a run, and who may drive its robot.

use rusty_contract::digest::hex;

/// A secret of 128 bits that stands for a right.
#[derive(Clone, Copy)]
pub struct Token([u8; 16]);

impl Token {
    /// Draws a token.
    ///
    /// # Errors
    /// [`getrandom::Error`] if the operating system has no randomness.
    pub fn draw() -> Result<Self, getrandom::Error> {
        let mut bytes = [0; 16];
        getrandom::fill(&mut bytes)?;
        Ok(Self(bytes))
    }

    /// Returns it as 32 hexadecimal digits.
    #[must_use]
    pub fn to_hex(&self) -> String {
        hex(&self.0)
    }

    /// Whether a text is this token. The time depends on the length of the text only.
    #[must_use]
    pub fn is(&self, text: &str) -> bool {
        let own = self.to_hex();
        let differs = own.bytes().zip(text.bytes()).fold(0, |all, (a, b)| all | (a ^ b));
        own.len() == text.len() && std::hint::black_box(differs) == 0
    }
}

/// The tokens of a viewer: one to see and to control the time, one to drive.
#[derive(Clone, Copy)]
pub struct Rights {
    /// Sees the run, pauses it, changes its pace.
    pub view: Token,
    /// Also drives the robot; `None` where no page may.
    pub drive: Option<Token>,
}

impl Rights {
    /// Draws the tokens.
    ///
    /// # Errors
    /// [`getrandom::Error`] if the operating system has no randomness.
    pub fn draw(drive: bool) -> Result<Self, getrandom::Error> {
        Ok(Self { view: Token::draw()?, drive: drive.then(Token::draw).transpose()? })
    }

    /// Returns the part of an address that carries them, without the mark ahead of it.
    #[must_use]
    pub fn text(&self) -> String {
        let drive = self.drive.map_or(String::new(), |token| format!("&drive={}", token.to_hex()));
        format!("view={}{drive}", self.view.to_hex())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_token_is_itself_and_no_other_text() {
        let (token, other) = (Token::draw().unwrap(), Token::draw().unwrap());
        let hex = token.to_hex();
        assert!(token.is(&hex) && hex.len() == 32);
        for wrong in ["", &hex[..31], &format!("{hex}0"), &other.to_hex(), &hex.to_uppercase()] {
            assert!(!token.is(wrong) || wrong == hex, "{wrong}");
        }
    }
}
