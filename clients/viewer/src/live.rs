//! A run that goes on: reads its frames and answers, and controls its time.

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

use rusty_clients::ClientError;
use rusty_contract::belief::tidy;
use rusty_contract::control::{ControlReply, ControlRequest};
use rusty_contract::{
    BeliefHeader, BeliefKind, Brief, Credentials, Effects, Frame, Json as _, Phase, Reply, RunName,
    Tally, TruthKey, WeightedPose, errln,
};
use rusty_link::{LinkError, Observer, Peer};
use rusty_ros::Description;

use crate::flow::{Flow, Share};
use crate::hub::Hub;
use crate::record::{Moment, Shown, belief};
use crate::scene::{Mode, PageRequest, Scene, Status};

/// Time between two looks at the run: while ticks come, while none do, and while pages get
/// a few of them only.
const LOOK: Duration = Duration::from_millis(1);
const IDLE_LOOK: Duration = Duration::from_millis(2);
const REDUCED_LOOK: Duration = Duration::from_millis(4);
/// Time without a tick after which pages get the latest one, while they get a few only: the
/// processes of such a run wait for each other, and for a core.
const REDUCED_IDLE: Duration = Duration::from_millis(60);
/// Time between two beliefs of an estimator on pages: that between two pictures.
const BELIEF_TIME: Duration = Duration::from_millis(16);
/// Time that a run may take to appear and to reply.
const JOIN_TIME: Duration = Duration::from_secs(20);
/// Time for the reply to a control request: steps may take as long as they want.
const CONTROL_TIME: Duration = Duration::from_secs(3600);
/// Time between two requests for the state of the run.
const STATUS_TIME: Duration = Duration::from_secs(1);
/// Frames that wait for their tally.
const MOST_WAITING: usize = 24;

/// A run under observation.
pub struct LiveRun {
    observer: Observer,
    /// The key, and what it opens.
    secret: Option<(TruthKey, Brief)>,
    effects: Option<Effects>,
    waiting: VecDeque<Moment>,
    tally: Box<Tally>,
    poses: Vec<WeightedPose>,
    /// The latest belief of each estimator, if pages did not get it.
    beliefs: BTreeMap<usize, Held>,
    beliefs_at: Option<Instant>,
    flow: Flow,
    /// The latest tick, if pages did not get all of it, and whether they got its trace.
    skipped: Option<(Arc<Moment>, bool)>,
    ended: Option<Phase>,
}

/// A belief that pages did not get.
struct Held {
    tick: u64,
    /// Its kind, and the number of all its poses.
    kind: (BeliefKind, u32),
    /// Those that came.
    poses: Vec<WeightedPose>,
}

impl LiveRun {
    /// Observes a run, with the key of `credentials` or the one that its server left for
    /// scorers that are started by hand.
    ///
    /// # Errors
    /// [`ClientError`] if there is no such run, or the key is of another one.
    pub fn open(
        run: &RunName,
        launcher: Option<u32>,
        credentials: Option<Credentials>,
        stop: &AtomicBool,
    ) -> Result<Self, ClientError> {
        let launcher = launcher.map(Peer::new);
        let observer = Observer::open(run, launcher.as_ref(), JOIN_TIME, stop)?;
        let key = credentials.and_then(|c| c.truth).or_else(|| observer.key_left());
        let start = observer.start();
        let secret = match (key, &start.sealed_brief) {
            (Some(key), Some(sealed)) => {
                let json = key.open_brief(start.run_id, sealed)?;
                let unreadable = |e| ClientError::Unusable(format!("the run's brief: {e}"));
                let brief = Brief::from_json(&json).map_err(unreadable)?;
                Some((key, brief))
            }
            _ => None,
        };
        let effects = secret.as_ref().map(|(_, brief)| Effects::of(&brief.header));
        let participants = secret.as_ref().map_or(1, |(_, brief)| brief.header.roster.len());
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        Ok(Self {
            observer,
            secret,
            effects,
            waiting: VecDeque::new(),
            tally: Box::default(),
            poses: Vec::new(),
            beliefs: BTreeMap::new(),
            beliefs_at: None,
            flow: Flow::new(participants, cores, Instant::now()),
            skipped: None,
            ended: None,
        })
    }

    /// What the run was told to scorers; `None` without the key.
    #[must_use]
    pub fn brief(&self) -> Option<&Brief> {
        self.secret.as_ref().map(|(_, brief)| brief)
    }

    /// The run's folder in shared memory.
    #[must_use]
    pub fn folder(&self) -> &std::path::Path {
        self.observer.domain().folder()
    }

    /// What a page is told of the run.
    #[must_use]
    pub fn scene(&self) -> Scene {
        match self.brief() {
            Some(brief) => Scene::of(&brief.header, Mode::Run),
            None => {
                let remark = "The truth, the map and the answers are hidden: this viewer has no \
                              key. Start the run with `sim-server launch --watch` to see them.";
                let scene = Scene::of_start(self.observer.start(), Mode::Run);
                scene.with_remark(Some(remark.to_owned()))
            }
        }
    }

    /// Returns what an app is told of the run: the truth and the answers with the key.
    #[must_use]
    pub fn description(&self) -> Description {
        match self.brief().map(|brief| &brief.header) {
            Some(header) => Description { truth: !header.is_blind(), ..Description::of(header) },
            None => Description::of_start(self.observer.start()),
        }
    }

    /// Shows the run until it ends or `stop` is raised. Returns how it ended; `None` if
    /// its server was killed.
    ///
    /// # Errors
    /// [`ClientError`] if shared memory fails, or a truth does not open.
    pub fn show(&mut self, hub: &Hub, stop: &AtomicBool) -> Result<Option<Phase>, ClientError> {
        let mut came_at = Instant::now();
        while !stop.load(Ordering::Relaxed) {
            // Before the look, so that the last frames of a run are seen.
            let is_over = self.observer.is_over();
            let is_idle = !self.look(hub)?;
            let is_reduced = self.flow.is_reduced(hub.is_at_full_speed());
            if !is_idle {
                came_at = Instant::now();
            }
            let is_still = is_idle && (!is_reduced || came_at.elapsed() >= REDUCED_IDLE);
            if is_still || self.ended.is_some() {
                if let Some((latest, is_traced)) = self.skipped.take() {
                    hub.tick(&latest, !is_traced);
                }
                self.show_beliefs(hub, false);
            }
            if self.ended.is_some() || (is_over && is_idle) {
                return Ok(self.ended);
            }
            std::thread::sleep(match (is_reduced, is_idle) {
                (true, _) => REDUCED_LOOK,
                (false, true) => IDLE_LOOK,
                (false, false) => LOOK,
            });
        }
        Ok(None)
    }

    /// Takes all that came; returns whether anything did.
    fn look(&mut self, hub: &Hub) -> Result<bool, ClientError> {
        let mut came = false;
        while let Some(frame) = self.observer.next_frame()? {
            came = true;
            if frame.run_id == self.observer.start().run_id {
                self.take(&frame)?;
            }
        }
        while let Some(sealed) = self.observer.next_tally()? {
            let Some((key, _)) = &self.secret else { break };
            sealed.open_into(key, &mut self.tally);
            self.close(hub);
        }
        if self.secret.is_none() {
            while let Some(taken) = self.waiting.pop_front() {
                self.show_tick(hub, taken);
            }
        }
        while let Some(header) = self.observer.next_belief(&mut self.poses) {
            self.hold_belief(&header);
        }
        let is_time = self.beliefs_at.is_none_or(|at| at.elapsed() >= BELIEF_TIME);
        if is_time && !self.flow.is_reduced(hub.is_at_full_speed()) {
            self.show_beliefs(hub, false);
        }
        Ok(came)
    }

    fn take(&mut self, frame: &Frame) -> Result<(), ClientError> {
        if frame.phase() != Phase::Tick {
            self.ended = Some(frame.phase());
            return Ok(());
        }
        let truth = match &self.secret {
            Some((key, _)) => frame.open_truth(key)?.map(|truth| truth.pose_in_world()),
            None => None,
        };
        self.waiting.push_back(Moment {
            tick: frame.tick(),
            time_s: frame.time_s(),
            counts: frame.encoders(),
            truth,
            command: frame.command(),
            ranges_m: frame.ranges_m().map(<[f64]>::to_vec),
            readings: frame.readings().into(),
            // Until its tally comes.
            ..Moment::default()
        });
        if self.waiting.len() > MOST_WAITING {
            self.waiting.pop_front();
        }
        Ok(())
    }

    /// Shows the tick of the tally that was opened, if its frame was seen.
    fn close(&mut self, hub: &Hub) {
        let (tally, Some(effects)) = (&self.tally, &mut self.effects) else { return };
        while self.waiting.front().is_some_and(|taken| taken.tick < tally.tick) {
            self.waiting.pop_front();
        }
        let Some(mut taken) = self.waiting.pop_front_if(|taken| taken.tick == tally.tick) else {
            return;
        };
        let entries = tally.entries();
        effects.close(taken.tick, taken.ranges_m.is_some(), entries.iter().map(|e| e.reply()));
        taken.shown = effects
            .replies()
            .zip(entries)
            .map(|(reply, entry)| Shown {
                estimate: reply.estimate().copied(),
                times_ns: (entry.reply() != Reply::Missing)
                    .then_some([entry.answer.compute_ns, entry.latency_ns]),
            })
            .collect();
        taken.digest = tally.run_digest;
        self.show_tick(hub, taken);
    }

    fn show_tick(&mut self, hub: &Hub, moment: Moment) {
        if let Some((passed, _)) = self.skipped.take() {
            hub.feed.pass(&passed);
        }
        let moment = Arc::new(moment);
        match self.flow.share(moment.tick, hub.is_at_full_speed(), Instant::now()) {
            Share::Whole => {
                if self.flow.is_reduced(hub.is_at_full_speed()) {
                    self.show_beliefs(hub, true);
                }
                hub.tick(&moment, true);
            }
            Share::Trace => {
                hub.trace(&moment);
                self.skipped = Some((moment, true));
            }
            Share::Nothing => self.skipped = Some((moment, false)),
        }
    }

    /// Keeps a belief until pages get it, or the next one comes.
    fn hold_belief(&mut self, header: &BeliefHeader) {
        let Some((_, brief)) = &self.secret else { return };
        let is_it = |name: &str| brief.header.answering().position(|p| p.name == name);
        let kind = BeliefKind::of_number(header.kind);
        let (Some(index), Some(kind)) = (header.name().and_then(is_it), kind) else { return };
        if header.run_id == self.observer.start().run_id && tidy(&mut self.poses) > 0 {
            let kind = (kind, header.whole.max(header.count));
            let poses = std::mem::take(&mut self.poses);
            let before = self.beliefs.insert(index, Held { tick: header.tick, kind, poses });
            // Its memory serves again.
            self.poses = before.map_or_else(Vec::new, |before| before.poses);
        }
    }

    /// Shows the beliefs that are kept, at once or with the next tick.
    fn show_beliefs(&mut self, hub: &Hub, is_later: bool) {
        while let Some((index, Held { tick, kind, poses })) = self.beliefs.pop_first() {
            hub.belief(index, belief(tick, index, kind, &poses).into(), is_later);
            self.beliefs_at = Some(Instant::now());
        }
    }
}

/// Carries out what pages ask of the time of a run, until no page can ask any more. Others
/// may control the run, too: while a page is open, the state is asked for now and then.
pub fn control(run: &RunName, requests: &Receiver<PageRequest>, hub: &Hub, ended: &AtomicBool) {
    let mut shown = None;
    let mut ask = |request: ControlRequest| {
        let status = match rusty_link::control(run, request, CONTROL_TIME) {
            Ok(ControlReply::Status(status)) => {
                hub.set_full_speed(status.pace.is_none());
                let state = if status.paused { "paused" } else { "running" };
                Status::new(state, status.pace, "")
            }
            Ok(ControlReply::Refused(why)) => {
                let (state, pace) =
                    shown.as_ref().map_or(("running", None), |s: &Status| (s.state, s.pace));
                Status::new(state, pace, format!("{run} {why}"))
            }
            Ok(ControlReply::Start(_)) => return,
            // The end of the run is shown by the one who sees it.
            Err(LinkError::ServerGone { .. } | LinkError::Domain(_)) => return,
            Err(e) => return errln!("{e}"),
        };
        // What was asked for is answered, also where it changed nothing.
        let is_news = request != ControlRequest::Status || shown.as_ref() != Some(&status);
        if is_news && !ended.load(Ordering::Relaxed) {
            hub.set_status(&serde_json::to_string(&status).unwrap_or_default());
            shown = Some(status);
        }
    };
    ask(ControlRequest::Status);
    loop {
        match requests.recv_timeout(STATUS_TIME) {
            Ok(PageRequest::Pause) => ask(ControlRequest::Pause),
            Ok(PageRequest::Resume) => ask(ControlRequest::Resume),
            Ok(PageRequest::Step { ticks }) => ask(ControlRequest::Step(ticks.max(1))),
            Ok(PageRequest::Pace { factor }) => ask(ControlRequest::Pace(factor)),
            // A run does not go back; driving has its own way.
            Ok(PageRequest::Seek { .. } | PageRequest::Drive { .. }) => {}
            Err(RecvTimeoutError::Timeout) if ended.load(Ordering::Relaxed) => return,
            Err(RecvTimeoutError::Timeout) if hub.counts().0 == 0 => {}
            Err(RecvTimeoutError::Timeout) => ask(ControlRequest::Status),
            Err(RecvTimeoutError::Disconnected) => return,
        }
    }
}
