//! From a key to the tick that carries its command, and to the picture of its effect.

use std::sync::atomic::AtomicBool;
use std::time::Duration;

use rusty_link::{Observer, monotonic_ns};
use rusty_tests::viewed::Viewed;
use rusty_tests::{arg, folder, fresh_run, repository, sim_server, until};

use crate::figures::{number, print, wait};

/// Notes when keys come and when ticks are drawn, in the time of the page, ms.
const NOTES: &str = "
globalThis.pressed = 0;
globalThis.pictures = [];
const note = (event) => { if (!event.repeat) [pressed, pictures] = [event.timeStamp, []]; };
addEventListener('keydown', note, true);
addEventListener('keyup', note, true);
let draws = rustyView.draws;
Object.defineProperty(rustyView, 'draws', {
  get: () => draws,
  set: (count) => { draws = count; pictures.push([rustyView.drawnTick, performance.now()]); },
});
";

/// Time from a picture to the next key, ms, and by how much it grows: keys come in all
/// parts of a tick.
const REST_MS: usize = 130;
const SHIFT_MS: usize = 7;
const TICK_MS: usize = 20;

pub fn measure(runs: usize) {
    let scenario = repository().join("clients/viewer/scenarios/drive.toml");
    let (run, out) = (fresh_run("keys"), folder());
    let args = [arg(&scenario), "--ticks", "1000000"];
    let viewed = Viewed::launch(&run, out.path(), &[&args]);
    let mut browser = crate::browser();
    browser.visit(&viewed.address);
    wait(&mut browser, "!document.getElementById('drive').hidden && rustyView.ticks > 0");
    browser.value("document.getElementById('drive').click()");
    browser.value(NOTES);
    let wait_s = Duration::from_secs(20);
    let observer = Observer::open(&run, None, wait_s, &AtomicBool::new(false)).expect("a run");
    let next = || observer.next_frame().expect("a frame");
    let (mut ticks, mut pictures) = (Vec::new(), Vec::new());
    for count in 0..10 * runs {
        let kind = if count % 2 == 0 { "keyDown" } else { "keyUp" };
        std::thread::sleep(Duration::from_millis((REST_MS + count * SHIFT_MS % TICK_MS) as u64));
        let mut before = None;
        while let Some(frame) = next() {
            before = Some(frame.command());
        }
        let begun_ns = monotonic_ns();
        browser.key(kind, "ArrowUp", 38, "");
        let mut carrier = None;
        until("a tick with the command of the key", || {
            while let Some(frame) = next().filter(|_| carrier.is_none()) {
                if before.is_some_and(|before| before != frame.command()) {
                    carrier = Some((frame.tick(), frame.published_ns));
                }
            }
            carrier.is_some()
        });
        let Some((tick, published_ns)) = carrier else { continue };
        ticks.push(published_ns.saturating_sub(begun_ns) as f64 * 1e-6);
        let is_it = format!("([tick]) => tick >= {tick}");
        wait(&mut browser, &format!("pictures.some({is_it})"));
        pictures.push(number(&mut browser, &format!("pictures.find({is_it})[1] - pressed")));
    }
    println!("Keys at 50 ticks per second, where a tick lasts 20 ms:");
    print("  key to the tick that carries its command", "ms", &mut ticks);
    print("  key to the picture of its effect", "ms", &mut pictures);
    sim_server(&["control", run.as_str(), "stop"]).expect(0);
    browser.visit("about:blank");
    viewed.ends_with(3);
}
