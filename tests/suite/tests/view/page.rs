//! The page of a log in a real browser: what it shows, keys, sizes, and what it says to
//! those who do not see it.

use rusty_tests::browser::Browser;
use rusty_tests::viewed::Viewed;
use rusty_tests::*;

/// The run of most tests here: two estimators, one with a covariance.
fn a_log() -> (Folder, PathBuf) {
    logged("page", &["--ticks", "200", "--seed", "5", "--add", "ekf=ekf"])
}

fn text_of(browser: &mut Browser, id: &str) -> String {
    let text = browser.value(&format!("document.getElementById('{id}').textContent"));
    text.as_str().unwrap().to_owned()
}

/// Problems that the page had itself.
fn faults(browser: &mut Browser) -> Vec<String> {
    let mut all = browser.complaints();
    all.retain(|text| !text.contains("Network.requestWillBeSent"));
    all
}

#[test]
fn a_log_is_played_paused_stepped_and_sought_by_keys_and_charts() {
    let (_out, log) = a_log();
    let Some(mut browser) = Browser::start() else { return };
    let viewed = Viewed::view(&[arg(&log)]);
    browser.resize(1280, 900);
    browser.visit(&viewed.address);
    browser.until("document.getElementById('tick').textContent === '199'");
    browser.until("document.getElementById('state').textContent === 'Paused.'");
    assert_eq!(text_of(&mut browser, "seed"), "5");
    assert_eq!(text_of(&mut browser, "digest"), {
        let info = sim_server(&["info", arg(&log), "--json"]).expect(0).json();
        text(&info, "digest").to_owned()
    });
    // The error is that of the log.
    let last = sim_server(&["info", arg(&log), "--tick", "199", "--json"]).expect(0).json();
    let (truth, pose) = (&last["truth"], &last["answers"][0]["pose"]);
    let off = |key: &str| pose[key].as_f64().unwrap() - truth[key].as_f64().unwrap();
    let error_m = off("x_m").hypot(off("y_m"));
    let cells = "[...document.querySelectorAll('#rows td')].map((c) => c.textContent)";
    let cells = browser.value(cells);
    let shown_m = cells[0].as_str().unwrap().parse::<f64>().unwrap();
    assert!(shown_m > 0.0 && (shown_m - error_m).abs() <= 0.0005, "{cells} is not {error_m} m");
    assert_eq!((&cells[2], cells[6] == "–"), (&json!("–"), false), "{cells}");
    // Seek to the middle with the slider, step by key, play again to the end.
    browser.value("document.getElementById('seek').focus()");
    browser.press("Home", 36);
    browser.until("document.getElementById('tick').textContent === '0'");
    browser.value("document.getElementById('map').focus()");
    browser.press(".", 190);
    browser.until("document.getElementById('tick').textContent === '1'");
    browser.press(" ", 32);
    browser.until("document.getElementById('tick').textContent === '199'");
    // A click on a chart goes to its tick.
    let middle = "(() => { const b = document.querySelector('#charts canvas').getBoundingClientRect();\
                  return [b.left + 46 + (b.width - 54) / 2, b.top + 30]; })()";
    let at = browser.value(middle);
    let at = [at[0].as_f64().unwrap(), at[1].as_f64().unwrap()];
    browser.mouse("mousePressed", at);
    browser.mouse("mouseReleased", at);
    let tick = "Number(document.getElementById('tick').textContent)";
    browser.until(&format!("Math.abs({tick} - 100) < 4"));
    assert_eq!(faults(&mut browser), [] as [&str; 0]);
}

#[test]
fn estimators_axes_and_zoom_follow_the_keys_and_fit_a_phone() {
    let (_out, log) = a_log();
    let Some(mut browser) = Browser::start() else { return };
    let viewed = Viewed::view(&[arg(&log)]);
    browser.resize(390, 844);
    browser.visit(&viewed.address);
    browser.until("document.getElementById('state').textContent === 'Paused.'");
    for (scheme, ink) in [("light", "#1a1a1a"), ("dark", "#e6e6e6")] {
        browser.media(scheme, "screen");
        let found = "getComputedStyle(document.documentElement).getPropertyValue('--ink').trim()";
        assert_eq!(browser.value(found), ink);
        let wide = "document.documentElement.scrollWidth > document.documentElement.clientWidth";
        assert_eq!(browser.value(wide), false, "{scheme}");
    }
    // What is drawn changes with each key, and comes back.
    let picture = "document.getElementById('map').toDataURL()";
    browser.until("document.getElementById('tick').textContent === '199'");
    let mut before = browser.value(picture);
    until("the last tick is drawn", || {
        std::thread::sleep(Duration::from_millis(300));
        let last = std::mem::replace(&mut before, browser.value(picture));
        last == before
    });
    browser.value("document.getElementById('map').focus()");
    browser.press("+", 187);
    browser.until(&format!("{picture}.length > 0 && rustyView.draws > 0"));
    until("the map is zoomed", || browser.value(picture) != before);
    browser.press("0", 48);
    until("the map is as before", || browser.value(picture) == before);
    browser.press("l", 76);
    assert_eq!(browser.value("document.getElementById('log').ariaPressed"), "true");
    browser.value("document.querySelector('#rows input').click()");
    until("an estimator is hidden", || browser.value(picture) != before);
    // Every control has a name, and the map tells what it shows.
    let unnamed = "[...document.querySelectorAll('button, select, input')].filter((c) => \
                   !(c.textContent.trim() || c.ariaLabel || c.labels?.[0]?.textContent.trim())).length";
    assert_eq!(browser.value(unnamed), 0);
    let label = browser.value("document.getElementById('map').ariaLabel");
    assert!(label.as_str().unwrap().contains("dead-reckoning is off by"), "{label}");
    assert_eq!(faults(&mut browser), [] as [&str; 0]);
}

#[test]
fn a_kidnapping_is_an_arrow_with_its_time() {
    let out = folder();
    let kidnapped = "name = \"k\"\nticks = 60\n[[kidnapping]]\ntick = 30\n\
        to = { x_m = 5.8, y_m = 4.9, theta_rad = 0.0 }\n";
    let estimator = estimator("dead-reckoning", &["dead-reckoning"], "");
    let file = out.write("k.toml", format!("{kidnapped}{estimator}{RECORDERS}"));
    run_to("kidnapped", &out.at("run"), &["launch", &file]).expect(0);
    let Some(mut browser) = Browser::start() else { return };
    let viewed = Viewed::view(&[arg(&out.at("run/run.log"))]);
    browser.visit(&viewed.address);
    browser.until("document.getElementById('tick').textContent === '59'");
    browser.value(
        "globalThis.texts = []; const { fillText } = CanvasRenderingContext2D.prototype;
        CanvasRenderingContext2D.prototype.fillText = function (text, ...at) {
            if (this.canvas.id === 'map') texts.push(text); fillText.call(this, text, ...at); };
        dispatchEvent(new Event('resize'));",
    );
    browser.until("texts.includes('0.6 s')");
    // Before it there is none.
    browser.value("document.getElementById('seek').focus()");
    browser.press("Home", 36);
    browser.until("document.getElementById('tick').textContent === '0'");
    browser.value("texts = []; dispatchEvent(new Event('resize'))");
    std::thread::sleep(Duration::from_millis(300));
    assert_eq!(browser.value("texts.length"), 0);
}

#[test]
fn where_no_motion_is_wanted_a_log_begins_paused() {
    let (_out, log) = a_log();
    let Some(mut browser) = Browser::start() else { return };
    let viewed = Viewed::view(&[arg(&log)]);
    let still = json!({ "name": "prefers-reduced-motion", "value": "reduce" });
    browser.ask("Emulation.setEmulatedMedia", json!({ "media": "", "features": [still] }));
    browser.visit(&viewed.address);
    browser.until("document.getElementById('state').textContent === 'Paused.'");
    let tick: u64 = text_of(&mut browser, "seek").parse().unwrap_or(0);
    assert!(tick < 199, "{tick}");
}

#[test]
fn sonars_are_cones_to_their_echoes_and_the_key_has_them() {
    let bumper = ["--set", "sensors.bumper.sectors=5", "--ticks", "40"];
    let (_out, log) = logged("sonars", &[&["sonar-ring"], &bumper[..]].concat());
    // The sonars are read in one of five ticks.
    let last = sim_server(&["info", arg(&log), "--tick", "35", "--json"]).expect(0).json();
    let readings = last["readings"].as_object().unwrap().iter();
    let ranges_m: Vec<f64> = readings
        .filter(|(name, _)| name.starts_with("sonar_m"))
        .filter_map(|(_, range_m)| range_m.as_f64().filter(|range_m| *range_m < 10.0))
        .collect();
    assert_eq!(ranges_m.len(), 16, "{last}");
    let Some(mut browser) = Browser::start() else { return };
    let viewed = Viewed::view(&[arg(&log)]);
    browser.visit(&viewed.address);
    browser.until("document.getElementById('tick').textContent === '39'");
    browser.until("document.getElementById('state').textContent === 'Paused.'");
    browser.value(
        "globalThis.radii = []; const { arc } = CanvasRenderingContext2D.prototype;
        CanvasRenderingContext2D.prototype.arc = function (x, y, r, ...angles) {
            if (this.canvas.id === 'map') radii.push(r); arc.call(this, x, y, r, ...angles); };
        dispatchEvent(new Event('resize'));",
    );
    for range_m in ranges_m {
        browser.until(&format!("radii.some((r) => Math.abs(r - {range_m}) < 1e-5)"));
    }
    let key = browser.value("document.getElementById('key').textContent");
    let key = key.as_str().unwrap();
    assert!(key.contains("sonar") && key.contains("bumper"), "{key}");
    assert_eq!(faults(&mut browser), [] as [&str; 0]);
}
