//! `Drawn`: how the player draws an estimator.

use rusty_plot::style::Look;
use serde::Serialize;

/// Name and look of an estimator: colours on light and on dark ground.
#[derive(Clone, Serialize)]
pub(super) struct Drawn {
    name: String,
    colours: [String; 2],
    width: f64,
}

impl Drawn {
    pub fn of(name: &str, look: &Look) -> Self {
        let colours = look.inks().map(|ink| ink.to_string());
        Self { name: name.to_owned(), colours, width: look.width }
    }
}
