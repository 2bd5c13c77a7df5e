//! What is what on the map, as a list.

use rusty_plot::{Drawing, Layer, escaped};

use super::beliefs::Beliefs;
use crate::scoring::key::{Symbol, key, possible_symbol};
use crate::scoring::trace::RunTrace;

/// The list, without what this map does not have.
pub(super) fn list(trace: &RunTrace) -> String {
    let has_scan = trace.ticks_with_truth() > 0 && trace.stops.iter().any(|stop| stop.has_scan);
    let scan = has_scan.then(|| "latest scan".to_owned());
    let mut list = "<ul class=\"key\">\n".to_owned();
    let beliefs = Beliefs::of(trace);
    let possible = beliefs.entries().enumerate();
    let possible = possible.map(|(k, name)| (possible_symbol(trace, k), name));
    for (symbol, name) in key(trace, (Symbol::Body, "robot"), scan, possible) {
        let mut drawing = Drawing::new((30.0, 22.0), &format!("key-{name}").replace(' ', "-"));
        drawing.layer(&Layer::default(), |canvas| symbol.draw(canvas, [1.0, 11.0]));
        // Next to its name; a page that is read aloud needs no drawing.
        let svg = drawing.finish("", "", "class=\"swatch\" aria-hidden=\"true\"");
        list.push_str(&format!("<li>{svg}<span>{}</span></li>\n", escaped(&name)));
    }
    list.push_str("</ul>\n");
    list
}
