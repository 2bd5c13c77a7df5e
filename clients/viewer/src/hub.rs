//! The pages that are open, and what one that opens later gets first.
//!
//! All that is shown goes through the [`Hub`], to pages and to the [`Feed`] of apps. Of a
//! page that is slow the oldest ticks are dropped. Scene and state are never dropped.

use std::collections::{BTreeMap, VecDeque};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use rusty_ros::Description;

use crate::foxglove::Feed;
use crate::outbox::{Bytes, Outbox};
use crate::record::{Moment, has_scan, has_sonars, history};

/// Most ticks of the history.
const MOST_TICKS: usize = 4096;

/// All pages, and what they share.
#[derive(Default)]
pub struct Hub {
    pages: Mutex<State>,
    /// The same for apps with the protocol of Foxglove.
    pub feed: Feed,
    /// Whether the run goes as fast as its participants answer.
    is_at_full_speed: AtomicBool,
}

#[derive(Default)]
struct State {
    scene: Option<Arc<str>>,
    status: Option<Arc<str>>,
    history: History,
    /// The latest tick, and the latest one with a scan.
    now: [Option<Bytes>; 2],
    /// The latest readings of bumper and sonars, and the latest ones with sonars.
    readings: [Option<Bytes>; 2],
    /// The latest belief of each estimator.
    beliefs: BTreeMap<usize, Bytes>,
    pages: Vec<Arc<Outbox>>,
    /// Pages that were ever open.
    opened: usize,
}

impl Hub {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.pages.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Shows another scene, with the ticks of a log if it is of one.
    pub fn set_scene(&self, json: &str, about: Description, ticks: &[Arc<Moment>]) {
        self.feed.begin(about);
        let mut state = self.lock();
        state.scene = Some(json.into());
        (state.history, state.now) = (History::default(), [None, None]);
        state.readings = [None, None];
        state.beliefs.clear();
        ticks.iter().for_each(|moment| state.history.push(&moment.encode()));
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
    pub fn tick(&self, moment: &Arc<Moment>, is_new: bool) {
        self.feed.tick(moment);
        let record: Bytes = moment.encode().into();
        let mut state = self.lock();
        if is_new {
            state.history.push(&record);
        }
        if let Some(readings) = moment.encode_readings().map(Bytes::from) {
            state.pages.iter().for_each(|page| page.record_later(&readings));
            if has_sonars(&readings) {
                state.readings[0] = Some(Arc::clone(&readings));
            }
            state.readings[1] = Some(readings);
        }
        state.pages.iter().for_each(|page| page.record(&record));
        if has_scan(&record) {
            state.now[0] = Some(Arc::clone(&record));
        }
        state.now[1] = Some(record);
    }

    /// Adds a tick to the history, and shows it with the next tick, without its scan.
    pub fn trace(&self, moment: &Moment) {
        let record: Bytes = history(&moment.encode()).into();
        let mut state = self.lock();
        state.history.push(&record);
        state.pages.iter().for_each(|page| page.record_later(&record));
    }

    /// Notes whether the run goes as fast as its participants answer.
    pub fn set_full_speed(&self, is_at_full_speed: bool) {
        self.is_at_full_speed.store(is_at_full_speed, Ordering::Relaxed);
    }

    /// Whether the run was last known to go as fast as its participants answer.
    #[must_use]
    pub fn is_at_full_speed(&self) -> bool {
        self.is_at_full_speed.load(Ordering::Relaxed)
    }

    /// Shows the belief of an estimator, at once or with the next tick.
    pub fn belief(&self, index: usize, record: Bytes, is_later: bool) {
        let mut state = self.lock();
        let send = if is_later { Outbox::record_later } else { Outbox::record };
        state.pages.iter().for_each(|page| send(page, &record));
        state.beliefs.insert(index, record);
    }

    /// Opens a page.
    pub fn open(&self) -> Arc<Outbox> {
        let mut state = self.lock();
        let page = Arc::new(Outbox::default());
        state.scene.iter().chain(&state.status).for_each(|json| page.text(Arc::clone(json)));
        page.record(&state.history.to_bytes());
        let latest = state.readings.iter().chain(&state.now).flatten();
        latest.chain(state.beliefs.values()).for_each(|record| page.record(record));
        state.pages.push(Arc::clone(&page));
        state.opened += 1;
        page
    }

    /// Closes a page.
    pub fn close(&self, page: &Arc<Outbox>) {
        page.close();
        self.lock().pages.retain(|other| !Arc::ptr_eq(other, page));
    }

    /// Closes all pages and apps.
    pub fn close_all(&self) {
        self.feed.close_all();
        self.lock().pages.drain(..).for_each(|page| page.close());
    }

    /// The pages and apps that are open, and those that ever were.
    #[must_use]
    pub fn counts(&self) -> (usize, usize) {
        let ((open, opened), state) = (self.feed.counts(), self.lock());
        (state.pages.len() + open, state.opened + opened)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outbox::Parcel;
    use crate::record::Shown;
    use rusty_contract::{LogHeader, Scenario};

    fn moment(tick: u64) -> Arc<Moment> {
        let ranges_m = tick.is_multiple_of(2).then(|| vec![1.0; 4]);
        Arc::new(Moment { tick, shown: vec![Shown::default()], ranges_m, ..Moment::default() })
    }

    fn tick(tick: u64) -> Vec<u8> {
        moment(tick).encode()
    }

    fn about() -> Description {
        let world = rusty_geometry::apartment().spec().clone();
        Description::of(&LogHeader::simulated("test", &Scenario::default(), world))
    }

    fn records(parcel: Option<Parcel>) -> Vec<u8> {
        match parcel {
            Some(Parcel::Records(records)) => records.concat(),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn a_page_that_opens_late_gets_scene_history_and_the_latest_scan() {
        let hub = Hub::default();
        hub.set_scene("scene", about(), &[]);
        (0..4).for_each(|k| hub.tick(&moment(k), true));
        hub.set_status("status");
        let page = hub.open();
        assert_eq!(page.next(), Some(Parcel::Text("scene".into())));
        assert_eq!(page.next(), Some(Parcel::Text("status".into())));
        let bare = 8 * 22;
        let bytes = records(page.next());
        assert_eq!(bytes.len(), 4 * bare + tick(2).len() + tick(3).len());
        assert_eq!((bytes[0], &bytes[4 * bare..4 * bare + tick(2).len()]), (3, &tick(2)[..]));
        hub.tick(&moment(4), true);
        hub.close(&page);
        assert_eq!(records(page.next()), &tick(4)[..]);
        assert_eq!((page.next(), hub.counts()), (None, (0, 1)));
    }

    #[test]
    fn traces_go_with_the_next_tick_and_have_no_scan() {
        let hub = Hub::default();
        let page = hub.open();
        hub.tick(&moment(0), true);
        assert_eq!(records(page.next()), tick(0));
        [2, 4].iter().for_each(|&k| hub.trace(&moment(k)));
        hub.tick(&moment(5), true);
        let traces = [history(&tick(2)), history(&tick(4))].concat();
        assert_eq!(records(page.next()), [traces, tick(5)].concat());
        // A page that opens later gets them, too.
        let late = records(hub.open().next());
        let all = [0, 2, 4, 5].map(|k| history(&tick(k))).concat();
        assert_eq!((&late[..all.len()], hub.is_at_full_speed()), (&all[..], false));
    }

    #[test]
    fn a_page_that_stands_still_loses_the_oldest_ticks_and_no_message() {
        let (hub, large) = (Hub::default(), Bytes::from(vec![7; 1 << 20]));
        let page = hub.open();
        hub.set_status("before");
        (0..20).for_each(|k| hub.belief(k, Arc::clone(&large), false));
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
