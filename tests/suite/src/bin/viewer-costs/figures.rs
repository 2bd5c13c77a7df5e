//! Figures, from the page and on the screen.

use std::time::Duration;

use rusty_metrics::percentile;
use rusty_tests::WATCHDOG;
use rusty_tests::browser::Browser;

/// Prints a figure as median, least and most.
pub fn print(what: &str, unit: &str, values: &mut [f64]) {
    let mut at = |fraction| percentile(values, fraction).unwrap_or(f64::NAN);
    let [least, median, most] = [0.0, 0.5, 1.0].map(&mut at);
    println!("{what}: {median:.2} {unit} ({least:.2} to {most:.2})");
}

/// The number that an expression in the page has.
#[track_caller]
pub fn number(browser: &mut Browser, expression: &str) -> f64 {
    let value = browser.value(expression);
    value.as_f64().unwrap_or_else(|| panic!("{expression}: expected a number, got {value}"))
}

/// Waits under the watchdog until an expression in the page is true, and asks seldom: each
/// question takes the time of the page.
#[track_caller]
pub fn wait(browser: &mut Browser, expression: &str) {
    let condition = format!("Boolean({expression})");
    rusty_tests::until_within(WATCHDOG, expression, || {
        std::thread::sleep(Duration::from_millis(20));
        browser.value(&condition) == true
    });
}
