//! A person drives with the keys of the page, and the drive is repeated without them.

use rusty_contract::Log;
use rusty_tests::browser::Browser;
use rusty_tests::viewed::Viewed;
use rusty_tests::*;

use crate::Opened as _;

/// The drive of the handbook, with a program for every participant.
fn scenario() -> String {
    arg(&repository().join("clients/viewer/scenarios/drive.toml")).to_owned()
}

/// What the page says of the robot's place.
const PLACE: &str = "document.getElementById('map').getAttribute('aria-label')";

/// The stick of a game pad, half way ahead, and let go until the robot stands.
fn drive_by_a_pad(browser: &mut Browser) {
    let pad = |y: f64| {
        format!(
            "navigator.getGamepads = () => [{{ connected: true, axes: [0.1, {y}], buttons: [] }}]"
        )
    };
    let here = browser.value(PLACE);
    browser.value(&pad(-0.5));
    until("the pad drives", || browser.value(PLACE) != here);
    browser.value(&pad(0.0));
    let tick = "Number(document.getElementById('tick').textContent)";
    until("the robot stands", || {
        let (here, then) = (browser.value(PLACE), browser.value(tick).as_u64().unwrap());
        browser.until(&format!("{tick} >= {then} + 10"));
        browser.value(PLACE) == here
    });
}

#[test]
fn a_drive_by_the_keys_of_a_page_is_repeated_bit_for_bit_without_the_person() {
    let (run, out) = (fresh_run("drive"), folder());
    let Some(mut browser) = Browser::start() else { return };
    let args = [&scenario(), "--ticks", "100000", "--seed", "5"];
    let viewed = Viewed::launch(&run, out.path(), &[&args]);
    assert!(viewed.tokens().contains("&drive="), "{}", viewed.address);
    browser.visit(&viewed.address);
    browser.until("!document.getElementById('drive').hidden && rustyView.ticks > 0");
    let place = PLACE;
    browser.until(&format!("{place}.includes('Robot at 6.00, 4.50 m')"));
    // Without Drive, keys do not drive.
    browser.key("keyDown", "ArrowUp", 38, "");
    browser.key("keyUp", "ArrowUp", 38, "");
    browser.value("document.getElementById('drive').click()");
    browser.key("keyDown", "ArrowUp", 38, "");
    browser.until(&format!("!{place}.includes('Robot at 6.')"));
    browser.key("keyDown", "ArrowLeft", 37, "");
    browser.until(&format!("Number(/heading (-?[0-9]+)/.exec({place})[1]) > 20"));
    browser.key("keyUp", "ArrowUp", 38, "");
    let here = browser.value(place);
    until("the robot turns on", || browser.value(place) != here);
    let here = browser.value(place);
    until("and on", || browser.value(place) != here);
    browser.key("keyUp", "ArrowLeft", 37, "");
    drive_by_a_pad(&mut browser);
    browser.press("Escape", 27);
    assert_eq!(browser.value("document.getElementById('pad').hidden"), true);
    assert_eq!(sim_server(&["control", run.as_str(), "stop"]).code, Some(0));
    browser.visit("about:blank");
    let (output, _) = viewed.ends_with(3);
    let report: Value = serde_json::from_str(&output).unwrap();
    assert_eq!(report["ended"], "interrupted");

    let log = Log::load(&out.at("run.log")).unwrap();
    let commands: Vec<[f64; 2]> =
        log.records.iter().map(|r| [r.command.v_m_s, r.command.omega_rad_s]).collect();
    for (ahead, left) in [(true, false), (true, true), (false, true)] {
        let is_it = |[v, omega]: &[f64; 2]| (*v > 0.0, *omega > 0.0) == (ahead, left);
        assert!(commands.iter().any(is_it), "{ahead} {left}");
    }
    for command in [[0.6, 0.0], [0.0, 1.5], [0.3, 0.0]] {
        assert!(commands.contains(&command), "{command:?}");
    }
    assert_eq!((commands[0], commands[commands.len() - 1]), ([0.0; 2], [0.0; 2]));

    let (recorded, written) = (out.at("run.log"), out.at("again"));
    let export = ["export", "scenario", arg(&recorded), "-o", arg(&written), "--json"];
    let exported = sim_server(&export).expect(0).json();
    assert_eq!(exported["drivers"], json!(["drive"]));
    let again = folder();
    let repeated = launch("again", again.path(), &[arg(&written.join("scenario.toml"))]);
    assert_eq!(repeated["ticks"], report["ticks"]);
    let other = Log::load(&again.at("run.log")).unwrap();
    assert_eq!(other.trailer.world_digest, log.trailer.world_digest);
    // The other estimators answer the same.
    let same = |(a, b): (&TickRecord, &TickRecord)| a.replies[1].same_bits(&b.replies[0]);
    assert!(log.records.iter().zip(&other.records).all(same));
}

#[test]
fn a_drive_needs_its_right_and_a_dead_man_stops_it() {
    let (run, out) = (fresh_run("right"), folder());
    let args = [&scenario(), "--ticks", "100000"];
    let viewed = Viewed::launch(&run, out.path(), &[&args]);
    // A page that may see, but not drive.
    let mut page = viewed.page();
    let (rights, _) = page.until(|m| m["message"] == "rights");
    assert_eq!(rights["drive"], false);
    page.until(|m| m["state"] == "running");
    page.ask(&json!({ "do": "drive", "ahead": 1.0, "left": 0.0 }));
    page.ask(&json!({ "do": "step", "ticks": 20 }));
    page.until(|m| m["state"] == "paused");
    let status = ["control", run.as_str(), "status", "--json"];
    let ticks = || sim_server(&status).expect(0).json()["ticks_done"].as_u64().unwrap();
    let before = ticks();
    // One that may, and that sends one command only.
    let drive = viewed.tokens().split_once("&drive=").unwrap().1;
    let origin = format!("http://127.0.0.1:{}", viewed.port());
    let mut driver = crate::Page::connect(viewed.port(), &origin).unwrap();
    driver.ask(&json!({ "view": viewed.view_token(), "drive": drive }));
    driver.until(|m| m["drive"] == true);
    driver.ask(&json!({ "do": "drive", "ahead": 1.0, "left": 0.0 }));
    // The requests of one page keep their order, and the command does not wait.
    driver.ask(&json!({ "do": "step", "ticks": 60 }));
    until("60 ticks", || ticks() == before + 60);
    assert_eq!(sim_server(&["control", run.as_str(), "stop"]).code, Some(0));
    drop((page, driver));
    viewed.ends_with(3);
    let log = Log::load(&out.at("run.log")).unwrap();
    let moving = log.records.iter().filter(|r| r.command.v_m_s > 0.0).count();
    assert_eq!(moving, 25, "the ticks of --dead-man");
}
