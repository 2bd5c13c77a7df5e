//! The player in the report: it plays the run, and draws what the log has.

use rusty_contract::log::LogReader;
use rusty_tests::browser::Browser;
use rusty_tests::*;

use crate::report::{NAMES, drawn_run, map, scene};

/// From the first tick to the last, and then no more; not where no motion is wanted.
#[test]
fn it_plays_by_itself_once() {
    let Some(mut browser) = Browser::start() else { return };
    let out = folder();
    launch("player", out.path(), &["--ticks", "20"]);
    let reader = LogReader::open(&out.at("run.log")).unwrap();
    let file = out.at("drawn.html");
    fs::write(&file, drawn_run(reader.header(), &NAMES[..3], 500)).unwrap();
    let tick = "Number(/tick (\\d+)/.exec(document.querySelector('#now').textContent)[1])";
    let button = "document.querySelector('#play').textContent";
    browser.open(&file, "");
    let begun = browser.value(tick).as_u64().unwrap();
    assert!(begun < 400, "it begins at {begun}");
    browser.until(&format!("{tick} > {begun} && {button} === 'Pause'"));
    browser.value("document.querySelector('#pace').value = '10'");
    browser.until(&format!("{tick} === 499 && {button} === 'Play'"));
    // Space plays again and pauses; a choice of a tick pauses, too.
    browser.value("document.activeElement.blur()");
    browser.press(" ", 32);
    browser.until(&format!("{tick} < 499 && {button} === 'Pause'"));
    browser.press(" ", 32);
    assert_eq!(browser.value(button), "Play");
    let paused = map(&mut browser);
    browser.press(".", 190);
    assert_ne!(map(&mut browser), paused, "a step");
    // Zoomed in, and the whole map again: its picture does not depend on how paths grew.
    (0..20).for_each(|_| browser.press(".", 190));
    let whole = map(&mut browser);
    browser.value("document.querySelector('#in').click()");
    assert_ne!(map(&mut browser), whole, "zoomed in");
    browser.value("document.querySelector('#fit').click()");
    assert_eq!(map(&mut browser), whole, "the whole map");
    let middle = "(() => { const b = document.querySelector('#map').getBoundingClientRect();\
        return [b.x + b.width / 2, b.y + b.height / 2]; })()";
    let [x, y] = [0, 1].map(|k| browser.value(middle)[k].as_f64().unwrap());
    browser.mouse("mousePressed", [x, y]);
    browser.mouse("mouseMoved", [x + 40.0, y]);
    browser.mouse("mouseReleased", [x + 40.0, y]);
    assert_ne!(map(&mut browser), whole, "dragged");
    let still = json!({ "name": "prefers-reduced-motion", "value": "reduce" });
    browser.ask("Emulation.setEmulatedMedia", json!({ "media": "", "features": [still] }));
    browser.open(&file, "");
    assert!(browser.value(tick) == 499 && browser.value(button) == "Play", "it moves");
    assert_eq!(browser.complaints(), [""; 0]);
}

/// A kidnapping, here of less than a metre, ends the path, and an arrow has its time.
#[test]
fn the_player_draws_a_kidnapping_as_an_arrow_and_no_path() {
    let Some(mut browser) = Browser::start() else { return };
    let out = folder();
    let kidnapped = "name = \"k\"\nticks = 60\nworld = \"apartment\"\n\
        start = { x_m = 6.0, y_m = 4.5, theta_rad = 0.0 }\n\
        [[kidnapping]]\ntick = 30\nto = { x_m = 5.8, y_m = 4.9, theta_rad = 0.0 }\n\
        [script]\nkind = \"straight\"\nv_m_s = 0.5\n";
    let file = out.write(
        "k.toml",
        format!("{kidnapped}{}{RECORDERS}", estimator("dead-reckoning", &["dead-reckoning"], "")),
    );
    let (run, log) = (out.at("run"), out.at("run/run.log"));
    run_to("kidnapped", &run, &["launch", &file]).expect(0);
    browser.open(&run.join("report.html"), "#tick=0");
    // All lines of paths that are made from here on, and what is written on the map.
    browser.value(
        "globalThis.far = 0; globalThis.texts = [];
        const { moveTo, lineTo } = Path2D.prototype;
        Path2D.prototype.moveTo = function (x, y) { this.end = [x, y]; moveTo.call(this, x, y); };
        Path2D.prototype.lineTo = function (x, y) {
            // But for the grid of the map.
            const [u, v] = this.end ?? [x, y];
            if (![u, v].every(Number.isInteger)) far = Math.max(far, Math.hypot(x - u, y - v));
            this.end = [x, y]; lineTo.call(this, x, y); };
        const { fillText } = CanvasRenderingContext2D.prototype;
        CanvasRenderingContext2D.prototype.fillText = function (text, ...at) {
            texts.push(text); fillText.call(this, text, ...at); };",
    );
    let grow = "(() => { const slider = document.querySelector('#tick');
        for (slider.value = 0; ; slider.value = Number(slider.value) + 1) {
            slider.dispatchEvent(new Event('input'));
            if (slider.value === slider.max) break;
        } return [far < 0.1, texts.includes('0.6 s')].join(); })()";
    assert_eq!(browser.value(grow), "true,true");
    // What the map says is what the log has.
    let tick = sim_server(&["info", arg(&log), "--tick", "45", "--json"]).expect(0).json();
    browser.open(&run.join("report.html"), "#tick=45");
    let said = scene(&mut browser);
    let pose = &tick["answers"][0]["pose"];
    let [x_m, y_m] = ["x_m", "y_m"].map(|axis| number(pose, axis));
    assert!(said.starts_with("tick 45 ") && x_m > 6.3, "{tick}");
    assert!(said.contains(&format!("dead-reckoning at {x_m:.2}, {y_m:.2} m.")), "{said}");
    assert_eq!(browser.complaints(), [""; 0]);
}
