//! The pages that are open, and what one that opens later gets first.
//!
//! A page has an [`Outbox`]. Filling it never waits: of a page that is slow the
//! oldest ticks are dropped. Scene and state are never dropped.

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use crate::record::{has_scan, history};

/// Most ticks of the history.
const MOST_TICKS: usize = 4096;
/// Most bytes that wait for a page.
const MOST_BYTES: usize = 8 << 20;
/// Time between two parcels of records to a page, and while more than one record comes
/// in a millisecond: every parcel wakes three processes, which the run's may wait for.
const PAUSE: Duration = Duration::from_millis(8);
const LONG_PAUSE: Duration = Duration::from_millis(50);

/// A message for a page.
pub type Bytes = Arc<[u8]>;

/// All pages, and what they share.
#[derive(Default)]
pub struct Hub(Mutex<State>);

#[derive(Default)]
struct State {
    scene: Option<Arc<str>>,
    status: Option<Arc<str>>,
    history: History,
    /// The latest tick, and the latest one with a scan.
    now: [Option<Bytes>; 2],
    /// The latest belief of each estimator.
    beliefs: BTreeMap<usize, Bytes>,
    pages: Vec<Arc<Outbox>>,
    /// Pages that were ever open.
    opened: usize,
}

impl Hub {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Shows another scene, with the ticks of a log if it is of one.
    pub fn set_scene(&self, json: &str, ticks: impl Iterator<Item = Bytes>) {
        let mut state = self.lock();
        state.scene = Some(json.into());
        (state.history, state.now) = (History::default(), [None, None]);
        state.beliefs.clear();
        ticks.for_each(|tick| state.history.push(&tick));
        let (pages, history) = (state.pages.clone(), state.history.to_bytes());
        pages.iter().for_each(|page| {
            page.text(json.into());
            page.record(&history);
        });
    }

    /// Shows another state.
    pub fn set_status(&self, json: &str) {
        let mut state = self.lock();
        state.status = Some(json.into());
        state.pages.iter().for_each(|page| page.text(json.into()));
    }

    /// Shows a tick, and adds it to the history if it `is_new`.
    pub fn tick(&self, record: Bytes, is_new: bool) {
        let mut state = self.lock();
        if is_new {
            state.history.push(&record);
        }
        state.pages.iter().for_each(|page| page.record(&record));
        if has_scan(&record) {
            state.now[0] = Some(Arc::clone(&record));
        }
        state.now[1] = Some(record);
    }

    /// Shows the belief of an estimator.
    pub fn belief(&self, index: usize, record: Bytes) {
        let mut state = self.lock();
        state.pages.iter().for_each(|page| page.record(&record));
        state.beliefs.insert(index, record);
    }

    /// Opens a page.
    pub fn open(&self) -> Arc<Outbox> {
        let mut state = self.lock();
        let page = Arc::new(Outbox::default());
        state.scene.iter().chain(&state.status).for_each(|json| page.text(Arc::clone(json)));
        page.record(&state.history.to_bytes());
        state.now.iter().flatten().chain(state.beliefs.values()).for_each(|r| page.record(r));
        state.pages.push(Arc::clone(&page));
        state.opened += 1;
        page
    }

    /// Closes a page.
    pub fn close(&self, page: &Arc<Outbox>) {
        page.close();
        self.lock().pages.retain(|other| !Arc::ptr_eq(other, page));
    }

    /// Closes all pages.
    pub fn close_all(&self) {
        self.lock().pages.drain(..).for_each(|page| page.close());
    }

    /// The pages that are open, and those that ever were.
    #[must_use]
    pub fn counts(&self) -> (usize, usize) {
        let state = self.lock();
        (state.pages.len(), state.opened)
    }
}

/// The past of a run, thinned so that a long one takes no more memory.
#[derive(Default)]
struct History {
    ticks: VecDeque<Vec<u8>>,
    /// One of this many ticks is kept, as a power of two.
    shift: u32,
    seen: u64,
}

impl History {
    fn push(&mut self, tick: &[u8]) {
        let is_kept = self.seen.is_multiple_of(1 << self.shift);
        self.seen += 1;
        if !is_kept {
            return;
        }
        self.ticks.push_back(history(tick));
        if self.ticks.len() > MOST_TICKS {
            let mut at = 0_usize;
            self.ticks.retain(|_| {
                at += 1;
                !at.is_multiple_of(2)
            });
            self.shift += 1;
        }
    }

    fn to_bytes(&self) -> Bytes {
        self.ticks.iter().flatten().copied().collect()
    }
}

/// What waits for a page.
#[derive(Default)]
pub struct Outbox {
    waiting: Mutex<Waiting>,
    news: Condvar,
}

#[derive(Default)]
struct Waiting {
    items: VecDeque<Item>,
    /// Of all records among them.
    bytes: usize,
    is_closed: bool,
    /// When the latest parcel of records was sent, and the pause after it.
    paused: Option<(Instant, Duration)>,
}

enum Item {
    Text(Arc<str>),
    Record(Bytes),
}

/// What a page is sent at a time.
#[derive(Debug, PartialEq)]
pub enum Parcel {
    /// JSON.
    Text(Arc<str>),
    /// Records, one after the other.
    Records(Vec<u8>),
}

impl Outbox {
    fn lock(&self) -> MutexGuard<'_, Waiting> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn text(&self, json: Arc<str>) {
        self.lock().items.push_back(Item::Text(json));
        self.news.notify_one();
    }

    fn record(&self, record: &Bytes) {
        let mut waiting = self.lock();
        waiting.bytes += record.len();
        waiting.items.push_back(Item::Record(Arc::clone(record)));
        while waiting.bytes > MOST_BYTES {
            let is_record = |item: &Item| matches!(item, Item::Record(_));
            let Some(oldest) = waiting.items.iter().position(is_record) else { break };
            if let Some(Item::Record(dropped)) = waiting.items.remove(oldest) {
                waiting.bytes -= dropped.len();
            }
        }
        self.news.notify_one();
    }

    fn close(&self) {
        self.lock().is_closed = true;
        self.news.notify_one();
    }

    /// Waits for something to send, in order; `None` once the page is closed and all is
    /// sent.
    pub fn next(&self) -> Option<Parcel> {
        let paused = self.lock().paused;
        if let Some((since, pause)) = paused {
            std::thread::sleep(pause.saturating_sub(since.elapsed()));
        }
        let mut waiting = self.lock();
        loop {
            let (mut records, mut count) = (Vec::new(), 0);
            while let Some(Item::Record(record)) =
                waiting.items.pop_front_if(|item| matches!(item, Item::Record(_)))
            {
                waiting.bytes -= record.len();
                records.extend_from_slice(&record);
                count += 1;
            }
            if !records.is_empty() {
                let now = Instant::now();
                let since = paused.map_or(LONG_PAUSE, |(since, _)| now - since);
                let pause = if count > since.as_millis() { LONG_PAUSE } else { PAUSE };
                waiting.paused = Some((now, pause));
                return Some(Parcel::Records(records));
            }
            if let Some(Item::Text(json)) = waiting.items.pop_front() {
                return Some(Parcel::Text(json));
            }
            if waiting.is_closed {
                return None;
            }
            waiting = self.news.wait(waiting).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::{Moment, Shown};
    use rusty_geometry::Twist;

    fn tick(tick: u64) -> Bytes {
        let shown = [Shown::default()];
        let (truth, command, digest) = (None, Twist::default(), [0; 16]);
        let ranges_m: &[f32] = if tick.is_multiple_of(2) { &[1.0; 4] } else { &[] };
        Moment { tick, time_s: 0.0, truth, command, digest, shown: &shown, ranges_m }
            .encode()
            .into()
    }

    fn records(parcel: Option<Parcel>) -> Vec<u8> {
        match parcel {
            Some(Parcel::Records(bytes)) => bytes,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn a_page_that_opens_late_gets_scene_history_and_the_latest_scan() {
        let hub = Hub::default();
        hub.set_scene("scene", std::iter::empty());
        (0..4).for_each(|k| hub.tick(tick(k), true));
        hub.set_status("status");
        let page = hub.open();
        assert_eq!(page.next(), Some(Parcel::Text("scene".into())));
        assert_eq!(page.next(), Some(Parcel::Text("status".into())));
        let bare = 8 * 22;
        let bytes = records(page.next());
        assert_eq!(bytes.len(), 4 * bare + tick(2).len() + tick(3).len());
        assert_eq!((bytes[0], &bytes[4 * bare..4 * bare + tick(2).len()]), (3, &tick(2)[..]));
        hub.tick(tick(4), true);
        hub.close(&page);
        assert_eq!(records(page.next()), &tick(4)[..]);
        assert_eq!((page.next(), hub.counts()), (None, (0, 1)));
    }

    #[test]
    fn a_page_that_stands_still_loses_the_oldest_ticks_and_no_message() {
        let (hub, large) = (Hub::default(), Bytes::from(vec![7; 1 << 20]));
        let page = hub.open();
        hub.set_status("before");
        (0..20).for_each(|k| hub.belief(k, Arc::clone(&large)));
        assert_eq!(page.next(), Some(Parcel::Text("before".into())));
        assert_eq!(records(page.next()).len(), 8 << 20);
    }

    #[test]
    fn the_history_of_a_long_run_is_bounded_and_even() {
        let mut history = History::default();
        (0..100_000).for_each(|k| history.push(&tick(k)));
        assert!((2048..=4096).contains(&history.ticks.len()), "{}", history.ticks.len());
        let number = |record: &Vec<u8>| f64::from_le_bytes(record[8..16].try_into().unwrap());
        let ticks: Vec<f64> = history.ticks.iter().map(number).collect();
        assert!(ticks.windows(2).all(|pair| pair[1] - pair[0] == ticks[1]), "{ticks:?}");
    }
}
