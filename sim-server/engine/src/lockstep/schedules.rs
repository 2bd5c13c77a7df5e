//! The protocol under schedules drawn from a seed: late, lost, doubled, wrong
//! and senseless answers, deaths, returns, timeouts, in any order.
//!
//! A [`World`] stands for everyone outside the machine and keeps separate
//! books; after every step the books are compared with what the machine does. A
//! schedule that breaks a promise is shortened to the events that matter and
//! printed. `RUSTY_SCHEDULES=1000000 cargo test -p sim-server schedules`
//! tries more of them.

mod world;

use world::{Event, World};

/// How many schedules, by default.
const SCHEDULES: u64 = 100_000;
/// Events in the longest of them.
const LONGEST: u64 = 120;

/// SplitMix64 (Steele, Lea & Flood, OOPSLA 2014): a test needs no more.
struct Dice(u64);

impl Dice {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    fn below(&mut self, n: u64) -> u64 {
        self.next() % n
    }
}

fn schedule(seed: u64) -> Vec<Event> {
    let mut dice = Dice(seed);
    let length = 1 + dice.below(LONGEST);
    (0..length).map(|_| Event::draw(&mut dice)).collect()
}

/// Plays a schedule; says what promise it breaks.
fn play(seed: u64, events: &[Event]) -> Result<Played, String> {
    let mut world = World::new(seed);
    let mut events = events.iter();
    // After the last event only time goes on, and that must be enough.
    let enough = 20_000;
    for _ in 0..enough {
        match world.step()? {
            world::Next::Busy => {}
            world::Next::Idle { until_ns } => match events.next() {
                Some(event) => world.happen(event, until_ns),
                None => world.now_ns = until_ns,
            },
            world::Next::Over => return Ok(world.played()),
        }
    }
    Err(format!("it does not end within {enough} steps"))
}

/// What a schedule came to, so that it shows when schedules stop reaching
/// something.
#[derive(Default)]
struct Played {
    ticks: u64,
    losses: u64,
    returns: u64,
    fed: u64,
    done: bool,
}

/// Leaves out events for as long as the schedule still fails.
fn shorten(seed: u64, mut events: Vec<Event>) -> Vec<Event> {
    let mut size = events.len();
    while size > 0 {
        let mut at = 0;
        while at < events.len() {
            let mut fewer = events.clone();
            fewer.drain(at..(at + size).min(events.len()));
            if play(seed, &fewer).is_err() {
                events = fewer;
            } else {
                at += size;
            }
        }
        size /= 2;
    }
    events
}

#[test]
fn no_schedule_breaks_a_promise() {
    let wanted = std::env::var("RUSTY_SCHEDULES").ok();
    let count = wanted.map_or(SCHEDULES, |n| n.parse().expect("RUSTY_SCHEDULES is a number"));
    let mut sum = Played::default();
    let mut whole = 0;
    for seed in 0..count {
        let events = schedule(seed);
        match play(seed, &events) {
            Ok(played) => {
                sum.ticks += played.ticks;
                sum.losses += played.losses;
                sum.returns += played.returns;
                sum.fed += played.fed;
                whole += u64::from(played.done);
            }
            Err(_) => {
                let events = shorten(seed, events);
                let problem = play(seed, &events).err().unwrap_or_default();
                let world = World::new(seed);
                panic!("seed {seed}: {problem}\n{world}\nthe shortest schedule: {events:#?}");
            }
        }
    }
    println!(
        "{count} schedules: {} ticks, {} losses, {} returns with {} ticks given again, {whole} \
         runs to the end",
        sum.ticks, sum.losses, sum.returns, sum.fed
    );
    // Schedules that reach nothing prove nothing.
    assert!(sum.ticks > count / 2 && sum.losses > count / 10, "too little happens");
    assert!(sum.returns > count / 50 && sum.fed > count / 50, "too few come back");
    assert!(whole > count / 50 && whole < count, "too few or too many runs come to their end");
}

#[test]
fn a_broken_promise_is_found_and_its_schedule_shortened() {
    // The same play with a world that keeps false books: it believes that an
    // answer to the tick before counts as one to this.
    let found = (0..2_000).find_map(|seed| {
        let events = schedule(seed);
        play_falsely(seed, &events).err().map(|_| (seed, events))
    });
    let (seed, events) = found.expect("two thousand schedules without an early answer");
    assert!(!events.is_empty(), "seed {seed}");
}

fn play_falsely(seed: u64, events: &[Event]) -> Result<Played, String> {
    let mut world = World::new(seed);
    world.false_books = true;
    for event in events {
        for _ in 0..1_000 {
            match world.step()? {
                world::Next::Busy => {}
                world::Next::Idle { until_ns } => {
                    world.happen(event, until_ns);
                    break;
                }
                world::Next::Over => return Ok(world.played()),
            }
        }
    }
    Ok(world.played())
}
