//! Ticks to the apps that subscribe to them.
//!
//! A message is encoded only if an app subscribes to its topic, and given to the app's
//! [`Outbox`], which never waits. A session ends where time goes back: the channels are
//! taken back and offered again, and every app subscribes again.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use rusty_contract::Estimate;
use rusty_ros::channel::Content;
use rusty_ros::{Description, Encoded, Encoder, Tick};

use super::message::{Subscription, advertise, data, server_info, time, unadvertise};
use crate::outbox::{Bytes, Outbox};
use crate::record::Moment;

/// All apps, and what they share.
#[derive(Default)]
pub struct Feed(Mutex<State>);

#[derive(Default)]
struct State {
    /// The run or log, once it is known.
    encoder: Option<Encoder>,
    about: Option<Description>,
    /// Number of the session, from 1; 0 before the first one.
    session: u32,
    /// Number of the first channel. No two sessions share a number.
    first_id: u32,
    /// Ticks of the session so far.
    taken: usize,
    /// The latest tick, and the latest one with a scan.
    now: [Option<Arc<Moment>>; 2],
    apps: Vec<Open>,
    /// Apps that were ever open.
    opened: usize,
}

struct Open {
    outbox: Arc<Outbox>,
    may_drive: bool,
    /// Subscription of each channel, by the channel's index.
    subscriptions: BTreeMap<usize, u32>,
}

impl Feed {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Begins with another run or log.
    pub fn begin(&self, about: Description) {
        let mut state = self.lock();
        state.about = Some(about);
        state.begin_session();
    }

    /// Sends a tick.
    pub fn tick(&self, moment: &Arc<Moment>) {
        self.pass(moment);
        let mut state = self.lock();
        state.now[0] = Some(Arc::clone(moment));
        if moment.ranges_m.is_some() {
            state.now[1] = Some(Arc::clone(moment));
        }
        let State { encoder: Some(encoder), apps, .. } = &mut *state else { return };
        let time: Bytes = time(nanoseconds(moment.time_s)).into();
        apps.iter().for_each(|app| app.outbox.record(&time));
        if apps.iter().any(|app| !app.subscriptions.is_empty()) {
            send_tick(encoder, moment, apps);
        }
    }

    /// Takes the next tick, which is not shown.
    pub fn pass(&self, moment: &Moment) {
        let mut state = self.lock();
        state.taken += 1;
        if let Some(encoder) = &mut state.encoder {
            encoder.advance(moment.time_s, moment.counts);
        }
    }

    /// Goes to the tick of a log after these: forward without those between, backward
    /// by a new session.
    pub fn go_to(&self, before: &[Arc<Moment>]) {
        let mut state = self.lock();
        if before.len() < state.taken {
            state.begin_session();
        }
        let State { encoder: Some(encoder), taken, .. } = &mut *state else { return };
        for moment in &before[*taken..] {
            encoder.advance(moment.time_s, moment.counts);
        }
        *taken = before.len();
    }

    /// Opens an app.
    #[must_use]
    pub fn open(&self, may_drive: bool) -> Arc<Outbox> {
        let mut state = self.lock();
        let app = Open { outbox: Arc::default(), may_drive, subscriptions: BTreeMap::new() };
        state.greet(&app);
        let outbox = Arc::clone(&app.outbox);
        state.apps.push(app);
        state.opened += 1;
        outbox
    }

    /// Closes an app.
    pub fn close(&self, outbox: &Arc<Outbox>) {
        outbox.close();
        let mut state = self.lock();
        state.apps.retain(|app| !app.is(outbox));
        state.select();
    }

    /// Closes all apps.
    pub fn close_all(&self) {
        self.lock().apps.drain(..).for_each(|app| app.outbox.close());
    }

    /// The apps that are open, and those that ever were.
    #[must_use]
    pub fn counts(&self) -> (usize, usize) {
        let state = self.lock();
        (state.apps.len(), state.opened)
    }

    /// Adds subscriptions, and sends what there is: latched messages, the latest scan, and
    /// the latest tick. A number of another session, or of a channel that has a
    /// subscription, is ignored.
    pub fn subscribe(&self, outbox: &Arc<Outbox>, wanted: &[Subscription]) {
        let mut state = self.lock();
        let State { encoder: Some(encoder), first_id, now, apps, .. } = &mut *state else { return };
        let Some(app) = apps.iter_mut().find(|app| app.is(outbox)) else { return };
        let mut subscriptions = BTreeMap::new();
        for Subscription { id, channel_id } in wanted {
            let index =
                channel_id.checked_sub(*first_id).map_or(usize::MAX, |index| index as usize);
            if index < encoder.channels().len() && !app.subscriptions.contains_key(&index) {
                subscriptions.insert(index, *id);
            }
        }
        app.subscriptions.extend(subscriptions.clone());
        let new = [Open { outbox: Arc::clone(outbox), may_drive: false, subscriptions }];
        select(encoder, &new, |_| true);
        let time_s = now[0].as_ref().map_or(0.0, |moment| moment.time_s);
        let _ = encoder.latched(time_s).map(|all| send(all, &new));
        if let [Some(latest), scan] = now {
            if let Some(scan) = scan.as_ref().filter(|scan| scan.tick != latest.tick) {
                select(encoder, &new, |of| matches!(of, Content::Scan | Content::ScanPoints));
                send_tick(encoder, scan, &new);
                select(encoder, &new, |_| true);
            }
            send_tick(encoder, latest, &new);
        }
        select(encoder, apps, |_| true);
    }

    /// Removes subscriptions.
    pub fn unsubscribe(&self, outbox: &Arc<Outbox>, ids: &[u32]) {
        let mut state = self.lock();
        if let Some(app) = state.apps.iter_mut().find(|app| app.is(outbox)) {
            app.subscriptions.retain(|_, id| !ids.contains(id));
        }
        state.select();
    }
}

impl State {
    fn begin_session(&mut self) {
        let Some(about) = &self.about else { return };
        let offered = self.encoder.as_ref().map_or(0, |encoder| encoder.channels().len() as u32);
        let gone: Vec<u32> = (self.first_id..self.first_id + offered).collect();
        self.encoder = Some(Encoder::new(about.clone()));
        (self.first_id, self.session) = (self.first_id + offered, self.session + 1);
        (self.taken, self.now) = (0, [None, None]);
        for app in &mut self.apps {
            app.subscriptions.clear();
            app.outbox.text(unadvertise(&gone).into());
        }
        self.apps.iter().for_each(|app| self.greet(app));
        self.select();
    }

    /// Offers an app the channels of the session.
    fn greet(&self, app: &Open) {
        let session = format!("{}-{}", std::process::id(), self.session);
        let channels = self.encoder.as_ref().map_or(&[][..], Encoder::channels);
        app.outbox.text(server_info(&session, app.may_drive).into());
        app.outbox.text(advertise(channels, self.first_id).into());
        if let Some(latest) = &self.now[0] {
            app.outbox.record(&time(nanoseconds(latest.time_s)).into());
        }
    }

    /// Selects the channels that have a subscription.
    fn select(&mut self) {
        if let Some(encoder) = &mut self.encoder {
            select(encoder, &self.apps, |_| true);
        }
    }
}

impl Open {
    fn is(&self, outbox: &Arc<Outbox>) -> bool {
        Arc::ptr_eq(&self.outbox, outbox)
    }
}

/// Selects the channels to which these apps subscribe, if their content is wanted.
fn select(encoder: &mut Encoder, apps: &[Open], is_wanted: impl Fn(Content) -> bool) {
    let indices = apps.iter().flat_map(|app| app.subscriptions.keys());
    let contents: Vec<Content> = indices.map(|&k| encoder.channels()[k].content).collect();
    encoder.select(|channel| contents.contains(&channel.content) && is_wanted(channel.content));
}

/// Sends the messages of the tick that the encoder took last, or the scan of an earlier one.
fn send_tick(encoder: &mut Encoder, moment: &Moment, apps: &[Open]) {
    let estimates: Vec<Option<Estimate>> = moment.shown.iter().map(|s| s.estimate).collect();
    let tick = Tick {
        time_s: moment.time_s,
        counts: moment.counts,
        command: moment.command,
        ranges_m: moment.ranges_m.as_deref(),
        readings: moment.readings.get(),
        truth: moment.truth,
        estimates: &estimates,
    };
    // No type fails.
    let _ = encoder.messages(&tick).map(|all| send(all, apps));
}

fn send<'a>(messages: impl Iterator<Item = Encoded<'a>>, apps: &[Open]) {
    for Encoded { channel, time_ns, cdr } in messages {
        for app in apps {
            if let Some(id) = app.subscriptions.get(&channel) {
                app.outbox.record(&data(*id, time_ns, cdr).into());
            }
        }
    }
}

fn nanoseconds(time_s: f64) -> u64 {
    (time_s * 1e9).round() as u64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outbox::Parcel;
    use crate::record::Shown;
    use rusty_contract::{LogHeader, Scenario};
    use rusty_geometry::EncoderCounts;
    use serde_json::Value;

    fn moment(k: u64) -> Arc<Moment> {
        let left = k as i64;
        Arc::new(Moment {
            tick: k,
            time_s: 0.5 * (k + 1) as f64,
            counts: EncoderCounts { left, right: left * left },
            ranges_m: k.is_multiple_of(4).then(|| vec![1.0; 180]),
            shown: vec![Shown::default()],
            ..Moment::default()
        })
    }

    fn feed() -> Feed {
        let feed = Feed::default();
        let world = rusty_geometry::apartment().spec().clone();
        feed.begin(Description::of(&LogHeader::simulated("test", &Scenario::default(), world)));
        feed
    }

    /// Reads the messages in JSON that wait, by their operation.
    fn texts<const N: usize>(outbox: &Outbox, expected: [&str; N]) -> [Value; N] {
        expected.map(|op| match outbox.next() {
            Some(Parcel::Text(json)) => {
                let json: Value = serde_json::from_str(&json).unwrap();
                assert_eq!(json["op"], op);
                json
            }
            other => panic!("{other:?} for {op}"),
        })
    }

    fn id(advertised: &Value, topic: &str) -> u32 {
        let channels = advertised["channels"].as_array().unwrap();
        let channel = channels.iter().find(|channel| channel["topic"] == topic).unwrap();
        channel["id"].as_u64().unwrap() as u32
    }

    fn subscriptions(advertised: &Value, topics: &[&str]) -> Vec<Subscription> {
        let subscription = |(k, topic): (u32, &&str)| Subscription {
            id: 70 + k,
            channel_id: id(advertised, topic),
        };
        (0..).zip(topics).map(subscription).collect()
    }

    /// Reads the records that wait: subscription (0 of a time) and time, ms.
    fn records(outbox: &Outbox) -> Vec<(u32, u64)> {
        let Some(Parcel::Records(records)) = outbox.next() else { panic!("no records") };
        let number = |bytes: &[u8]| u64::from_le_bytes(bytes.try_into().unwrap()) / 1_000_000;
        let of = |record: &Bytes| match record[0] {
            1 => (u32::from_le_bytes(record[1..5].try_into().unwrap()), number(&record[5..13])),
            _ => (0, number(&record[1..9])),
        };
        records.iter().map(of).collect()
    }

    #[test]
    fn a_subscriber_gets_what_it_asks_for_and_at_first_what_there_is() {
        let feed = feed();
        let app = feed.open(true);
        let [info, offered] = texts(&app, ["serverInfo", "advertise"]);
        assert_eq!(info["capabilities"], serde_json::json!(["time", "clientPublish"]));
        (0..6).for_each(|k| feed.tick(&moment(k)));
        assert_eq!(records(&app), [500, 1000, 1500, 2000, 2500, 3000].map(|ms| (0, ms)));
        let wanted = subscriptions(&offered, &["/map", "/scan", "/odom"]);
        feed.subscribe(&app, &wanted);
        // The map at the time of the latest tick, the scan at its own.
        assert_eq!(records(&app), [(70, 3000), (71, 2500), (72, 3000)]);
        // The same again, and a channel that there is not.
        let unknown = Subscription { id: 80, channel_id: u32::MAX };
        feed.subscribe(&app, &[&wanted[..], &[unknown]].concat());
        feed.tick(&moment(6));
        feed.unsubscribe(&app, &[72]);
        feed.tick(&moment(7));
        feed.tick(&moment(8));
        let expected = [(0, 3500), (72, 3500), (0, 4000), (0, 4500), (71, 4500)];
        assert_eq!((records(&app), feed.counts()), (expected.to_vec(), (1, 1)));
        feed.close(&app);
        assert_eq!((app.next(), feed.counts()), (None, (0, 1)));
    }

    #[test]
    fn time_that_goes_back_begins_a_session_and_ticks_between_count() {
        let (feed, log) = (feed(), (0..9).map(moment).collect::<Vec<_>>());
        let app = feed.open(false);
        let [first, offered] = texts(&app, ["serverInfo", "advertise"]);
        let odometry = |app: &Outbox| match app.next() {
            Some(Parcel::Records(records)) => records.last().unwrap()[13..].to_vec(),
            other => panic!("{other:?}"),
        };
        feed.subscribe(&app, &subscriptions(&offered, &["/odom"]));
        let show = |k: usize| {
            feed.go_to(&log[..k]);
            feed.tick(&log[k]);
        };
        (0..=5).for_each(show);
        let whole = odometry(&app);
        show(2);
        let [_, second, offered] = texts(&app, ["unadvertise", "serverInfo", "advertise"]);
        assert_ne!(first["sessionId"], second["sessionId"]);
        show(5);
        records(&app);
        // Numbers of the session before are ignored.
        feed.subscribe(&app, &[Subscription { id: 1, channel_id: 0 }]);
        feed.subscribe(&app, &subscriptions(&offered, &["/odom"]));
        assert_eq!(odometry(&app), whole);
    }
}
