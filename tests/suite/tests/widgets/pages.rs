//! The pages in a real browser: what each shows, and that its command gives the digest
//! that it shows.

use rusty_tests::browser::Browser;
use rusty_tests::*;

use crate::built;

/// A page in a browser, from a file.
fn open(file: &str) -> Option<Browser> {
    let page = built()?.join(file);
    let mut browser = Browser::start()?;
    browser.resize(1280, 900);
    browser.open(&page, "");
    Some(browser)
}

fn text_of(browser: &mut Browser, id: &str) -> String {
    let text = browser.value(&format!("document.getElementById('{id}').textContent"));
    text.as_str().unwrap().to_owned()
}

/// What went wrong, and what was loaded from elsewhere; a page's worker is a part of it.
fn faults(browser: &mut Browser) -> Vec<String> {
    let mut all = browser.complaints();
    all.retain(|text| !text.contains("\"url\":\"blob:"));
    all
}

/// Runs the command that a page shows, in the folder with `files`, and returns its digest.
#[track_caller]
fn digest_of(command: &str, files: &Folder) -> String {
    let filters = repository().join("clients/filters");
    let command = command.replace("clients/filters", arg(&filters));
    let mut shell = Command::new("sh");
    let out = files.at("native");
    shell.args(["-c", &format!("{command} --out '{}' --force", arg(&out))]);
    let path = std::env::join_paths([binaries(), Path::new("/usr/bin"), Path::new("/bin")]);
    shell.current_dir(files.path()).env("PATH", path.unwrap());
    text(&Process::spawn(&mut shell).wait().expect(0).json(), "digest").to_owned()
}

/// Waits for the first digest of a page, which comes with its command.
#[track_caller]
fn wait_for_digest(browser: &mut Browser) {
    browser.until("document.getElementById('digest').textContent.length === 32");
}

/// Compares the digest of a page with the one of its command.
#[track_caller]
fn compare(browser: &mut Browser, files: &Folder) {
    wait_for_digest(browser);
    let shown = "['command', 'digest'].map((id) => document.getElementById(id).textContent)";
    let shown = browser.value(shown);
    let (command, digest) = (shown[0].as_str().unwrap(), shown[1].as_str().unwrap());
    assert_eq!(digest_of(command, files), digest, "{command}");
    assert_eq!(text_of(browser, "remark"), "");
}

/// Sets a slider as a reader does.
fn slide(browser: &mut Browser, key: &str, value: &str) {
    browser.value(&format!(
        "(() => {{ const s = document.querySelector('input[data-key=\"{key}\"]'); \
         s.value = '{value}'; s.dispatchEvent(new Event('input', {{ bubbles: true }})); }})()"
    ));
}

#[track_caller]
fn at_tick(browser: &mut Browser, tick: u64) {
    browser.until(&format!("Number(document.getElementById('tick').textContent) >= {tick}"));
}

/// Pauses, and waits until what is shown stays.
fn pause(browser: &mut Browser) {
    browser.value("rustyWidget.player.play(false)");
    browser.until("!rustyWidget.player.isBusy && rustyWidget.player.shown === Math.floor(rustyWidget.player.at)");
}

#[test]
fn a_dashboard_that_is_not_touched_shows_a_run_that_repeats() {
    let Some(mut browser) = open("dashboard.html") else { return };
    let files = folder();
    at_tick(&mut browser, 40);
    pause(&mut browser);
    compare(&mut browser, &files);
    // The same ticks with other wheels: the whole run is simulated again.
    let before = text_of(&mut browser, "tick");
    slide(&mut browser, "robot.radius_bias_right", "0.01");
    slide(&mut browser, "robot.slip_std", "0");
    let digest = text_of(&mut browser, "digest");
    browser.until(&format!("document.getElementById('digest').textContent !== '{digest}'"));
    pause(&mut browser);
    assert_eq!(text_of(&mut browser, "tick"), before);
    compare(&mut browser, &files);
    assert_eq!(faults(&mut browser), [""; 0]);
}

#[test]
fn keys_drive_and_the_saved_scenario_repeats_the_drive() {
    let Some(mut browser) = open("dashboard.html") else { return };
    at_tick(&mut browser, 5);
    browser.value("document.getElementById('drive').click()");
    browser.key("keyDown", "ArrowUp", 38, "");
    let blocked = "!document.getElementById('wall').hidden";
    browser.until(blocked);
    browser.key("keyUp", "ArrowUp", 38, "");
    browser.key("keyDown", "ArrowLeft", 37, "");
    browser.until("rustyWidget.rows.at(-1)[6] > 0.5");
    browser.key("keyUp", "ArrowLeft", 37, "");
    browser.press("Escape", 27);
    browser.until("document.getElementById('drive').ariaPressed === 'false'");
    browser.until("rustyWidget.rows.at(-1)[6] === 0");
    pause(&mut browser);
    browser.value(
        "URL.createObjectURL = (blob) => { blob.text().then((t) => { globalThis.saved = t; }); \
         return '#'; }; document.getElementById('save').click()",
    );
    browser.until("globalThis.saved");
    let files = folder();
    files.write("widget.toml", browser.value("saved").as_str().unwrap());
    compare(&mut browser, &files);
    // Another wheel under the same commands.
    slide(&mut browser, "robot.slip_std", "0.05");
    let digest = text_of(&mut browser, "digest");
    browser.until(&format!("document.getElementById('digest').textContent !== '{digest}'"));
    pause(&mut browser);
    browser.value("globalThis.saved = ''; document.getElementById('save').click()");
    browser.until("globalThis.saved");
    files.write("widget.toml", browser.value("saved").as_str().unwrap());
    compare(&mut browser, &files);
}

#[test]
fn the_lidar_page_stops_at_the_cliffs_of_the_chapter() {
    let Some(mut browser) = open("lidar.html") else { return };
    browser.until("rustyWidget.cliffs.length > 0");
    assert_eq!(browser.value("rustyWidget.cliffs"), json!([6, 78, 103]));
    browser.until("document.getElementById('state').textContent.includes('Beam 5 reads 2.884 m')");
    slide(&mut browser, "lidar.dropout", "0.2");
    browser.until("[...rustyWidget.ranges].filter((range) => range === 8).length > 10");
    browser.value("document.getElementById('beam').focus()");
    browser.press("End", 35);
    browser.until("document.getElementById('number').textContent === '179'");
    pause(&mut browser);
    compare(&mut browser, &folder());
    assert_eq!(faults(&mut browser), [""; 0]);
}

#[test]
fn the_seed_lab_shows_the_rows_of_its_sweep() {
    let Some(mut browser) = open("seed-lab.html") else { return };
    browser.until("rustyWidget.runs.length === 48");
    compare(&mut browser, &folder());
    let runs =
        "rustyWidget.runs.map((run) => [String(run.seed), run.digest, String(run.figures[3])])";
    let runs = browser.value(runs);
    let files = folder();
    let sweep = text_of(&mut browser, "sweep").replace("lab.csv", arg(&files.at("lab.csv")));
    let words: Vec<&str> = sweep.split(' ').skip(1).collect();
    sim_server(&words).expect(0);
    let table = Table::read(&files.at("lab.csv"));
    assert_eq!(table.rows.len(), 48);
    let errors = table.numbers("final_position_error_m");
    for (k, run) in runs.as_array().unwrap().iter().enumerate() {
        assert_eq!(run[0], table.column("seed")[k]);
        assert_eq!(run[1], table.column("digest")[k]);
        let error: f64 = run[2].as_str().unwrap().parse().unwrap();
        assert_eq!(error.to_bits(), errors[k].to_bits());
    }
    // Seeds of 64 bits, and one that is none.
    let seed = |text: &str| {
        format!(
            "(() => {{ const s = document.getElementById('seed'); s.value = '{text}'; \
                 s.dispatchEvent(new Event('change')); }})()"
        )
    };
    browser.value(&seed("18446744073709551000"));
    browser.until("String(rustyWidget.runs[0].seed) === '18446744073709551000'");
    compare(&mut browser, &files);
    browser.value(&seed("18446744073709551616"));
    assert_eq!(browser.value("document.getElementById('seed').ariaInvalid"), "true");
}

#[test]
fn filters_in_a_page_answer_as_their_programs_do_also_when_kidnapped() {
    let Some(mut browser) = open("filters.html") else { return };
    let files = folder();
    at_tick(&mut browser, 60);
    browser.press("k", 75);
    browser.until("rustyWidget.kidnappings.length > 0 && rustyWidget.kidnappings[0].tick < 500");
    let after = browser.value("rustyWidget.kidnappings[0].tick").as_u64().unwrap() + 60;
    at_tick(&mut browser, after);
    pause(&mut browser);
    compare(&mut browser, &files);
    let far =
        browser.value("rustyWidget.estimators.map(({ name, errors }) => [name, errors[0] > 1])");
    assert_eq!(far[0], json!(["dead-reckoning", true]), "the robot was carried away");
    assert_eq!(far[2], json!(["ekf", false]), "an EKF that is lost does not answer");
    assert!(browser.value("rustyWidget.beliefs[1].length").as_u64().unwrap() > 100);
    assert_eq!(faults(&mut browser), [""; 0]);
}

#[test]
fn pages_fit_a_phone_name_their_controls_and_stand_still_where_that_is_wanted() {
    let Some(folder) = built() else { return };
    let Some(mut browser) = Browser::start() else { return };
    browser.resize(390, 844);
    let still = json!({ "name": "prefers-reduced-motion", "value": "reduce" });
    browser.ask("Emulation.setEmulatedMedia", json!({ "media": "", "features": [still] }));
    for page in ["dashboard.html", "lidar.html", "seed-lab.html", "filters.html"] {
        browser.open(&folder.join(page), "");
        wait_for_digest(&mut browser);
        assert_eq!(browser.value("rustyWidget.player.isOn"), false, "{page}");
        let wide = "document.documentElement.scrollWidth > document.documentElement.clientWidth";
        assert_eq!(browser.value(wide), false, "{page}");
        let unnamed = "[...document.querySelectorAll('button, select, input')].filter((c) => \
                       !(c.textContent.trim() || c.ariaLabel || c.labels?.[0]?.textContent.trim())).length";
        assert_eq!(browser.value(unnamed), 0, "{page}");
        assert_eq!(faults(&mut browser), [""; 0], "{page}");
    }
}
