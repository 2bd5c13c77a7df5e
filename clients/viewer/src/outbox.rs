//! What waits for one page or app. Filling it never waits: of one that is slow the oldest
//! records are dropped, and no text.

use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Most bytes that wait for a page.
const MOST_BYTES: usize = 8 << 20;
/// Time between two parcels of records to a page, and while more than one record comes
/// in a millisecond: every parcel wakes three processes, which the run's may wait for.
const PAUSE: Duration = Duration::from_millis(8);
const LONG_PAUSE: Duration = Duration::from_millis(50);

/// A record in bytes.
pub type Bytes = Arc<[u8]>;

/// What waits for a page or app.
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
    /// Whether anything among them is to be sent now.
    is_due: bool,
    is_closed: bool,
    /// When the latest parcel of records was sent, and the pause after it.
    paused: Option<(Instant, Duration)>,
}

enum Item {
    Text(Arc<str>),
    Pong(Vec<u8>),
    Record(Bytes),
}

/// What a page or app is sent at a time.
#[derive(Debug, PartialEq)]
pub enum Parcel {
    /// JSON.
    Text(Arc<str>),
    /// The answer to a ping.
    Pong(Vec<u8>),
    /// Records in their order.
    Records(Vec<Bytes>),
}

impl Outbox {
    fn lock(&self) -> MutexGuard<'_, Waiting> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn push(&self, item: Item) {
        self.lock().items.push_back(item);
        self.send();
    }

    /// Sends all that waits.
    fn send(&self) {
        self.lock().is_due = true;
        self.news.notify_one();
    }

    /// Adds a message in JSON, which is never dropped.
    pub fn text(&self, json: Arc<str>) {
        self.push(Item::Text(json));
    }

    /// Adds the answer to a ping.
    pub fn pong(&self, content: Vec<u8>) {
        self.push(Item::Pong(content));
    }

    /// Adds a record, and drops the oldest ones if too many bytes wait.
    pub fn record(&self, record: &Bytes) {
        self.record_later(record);
        self.send();
    }

    /// Adds a record that is sent with the next one, so that no process wakes up for it.
    pub fn record_later(&self, record: &Bytes) {
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
    }

    /// Ends it once all is sent.
    pub fn close(&self) {
        self.lock().is_closed = true;
        self.send();
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
            while !waiting.is_due {
                waiting = self.news.wait(waiting).unwrap_or_else(PoisonError::into_inner);
            }
            let mut records = Vec::new();
            while let Some(Item::Record(record)) =
                waiting.items.pop_front_if(|item| matches!(item, Item::Record(_)))
            {
                waiting.bytes -= record.len();
                records.push(record);
            }
            if !records.is_empty() {
                let now = Instant::now();
                let since = paused.map_or(LONG_PAUSE, |(since, _)| now - since);
                let pause =
                    if records.len() as u128 > since.as_millis() { LONG_PAUSE } else { PAUSE };
                waiting.paused = Some((now, pause));
                waiting.is_due = waiting.is_closed || !waiting.items.is_empty();
                return Some(Parcel::Records(records));
            }
            match waiting.items.pop_front() {
                Some(Item::Text(json)) => return Some(Parcel::Text(json)),
                Some(Item::Pong(content)) => return Some(Parcel::Pong(content)),
                // Records were taken above.
                Some(Item::Record(_)) => continue,
                None if waiting.is_closed => return None,
                None => waiting.is_due = false,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn records(outbox: &Outbox) -> Vec<u8> {
        match outbox.next() {
            Some(Parcel::Records(records)) => records.concat(),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn records_for_later_wake_nobody_and_go_with_the_next_item() {
        let outbox = Outbox::default();
        let record = |k: u8| Bytes::from([k]);
        outbox.record_later(&record(1));
        assert!(!outbox.lock().is_due);
        outbox.record(&record(2));
        assert_eq!(records(&outbox), [1, 2]);
        assert!(!outbox.lock().is_due);
        // Nothing is due after all was sent, also where more waits for later.
        outbox.text("status".into());
        assert_eq!(outbox.next(), Some(Parcel::Text("status".into())));
        outbox.record_later(&record(3));
        outbox.text("status".into());
        assert_eq!(records(&outbox), [3]);
        assert_eq!(outbox.next(), Some(Parcel::Text("status".into())));
        outbox.record_later(&record(4));
        outbox.close();
        assert_eq!((records(&outbox), outbox.next()), (vec![4], None));
    }
}
