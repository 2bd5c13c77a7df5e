//! Authenticity: no process answers for another participant, sends frames as the
//! server, controls a run without its key or reads others' answers in a tally.
//!
//! The participants of these runs are in one process, the test's, so that the
//! process id tells the server nothing: as with a hostile program that names
//! another process's id.

use std::fs::OpenOptions;
use std::os::unix::fs::{FileExt as _, PermissionsExt as _};
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;

use rusty_contract::answer::Message;
use rusty_contract::tally::TallyEntry;
use rusty_contract::{
    Answer, Credentials, JoinReply, JoinRequest, Participant, Phase, Role, Start, Tally, TruthKey,
};
use rusty_geometry::{EncoderCounts, Twist};
use rusty_link::{ClientLink, LinkError, ServerLink, WaitPolicy};
use rusty_tests::hand::{PATIENCE, join, next_frame as next};
use rusty_tests::*;

/// Two estimators by hand, `me` and `victim`, for 5 ticks.
const ROSTER: [&str; 6] = ["--add", "me", "--add", "victim", "--ticks", "5"];

#[test]
fn an_answer_for_another_participant_is_dropped_and_reported() {
    let live = Live::start("serve", "forged", &[&ALONE, &ROSTER]);
    let mut me = join(&live.run, "me").unwrap();
    let mut victim = join(&live.run, "victim").unwrap();
    for tick in 0..5 {
        let frame = next(&mut me).unwrap();
        assert_eq!((frame.phase(), frame.tick()), (Phase::Tick, tick));
        let lie = SE2::new(1e3, 1e3, 0.0);
        for message in [Message::Failed, Message::Leave, Message::Reply(lie.into())] {
            let mut answer = Answer::carrying(&message);
            answer.run_id = victim.start().run_id;
            answer.participant = victim.start().participant;
            answer.ticket = victim.start().ticket;
            answer.tick = tick;
            answer.digest_seen = frame.digest();
            me.send_forged(answer).unwrap();
        }
        me.answer(&frame, &Message::Reply(Reply::Abstain), false).unwrap();
        let own = next(&mut victim).unwrap();
        victim.answer(&own, &Message::Reply(SE2::identity().into()), false).unwrap();
    }
    for link in [&mut me, &mut victim] {
        assert_eq!(next(link).unwrap().phase(), Phase::Done);
        link.send_raw(Answer::carrying(&Message::Leave)).unwrap();
    }
    drop((me, victim));
    let after = live.ends_with(0);
    assert_eq!(after.report["losses"], json!([]));
    for participant in list(&after.report, "participants") {
        let name = text(participant, "name");
        if name == "sim-server" {
            continue;
        }
        assert_eq!(participant["answers"], 5, "{participant}");
        assert_eq!(participant["abstained"], if name == "me" { 5 } else { 0 }, "{participant}");
        assert_eq!(participant["strays"], 0, "{participant}");
    }
    after.says("without that participant's key");
}

#[test]
fn a_process_without_the_key_cannot_join() {
    let live = Live::start("serve", "keyless", &[&ALONE, &ROSTER]);
    until("the keys are there", || Domain::credentials_file(&live.run, "victim").exists());
    let file = Domain::credentials_file(&live.run, "victim");
    assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o600);
    let own = fs::read_to_string(Domain::credentials_file(&live.run, "me")).unwrap();
    let request = JoinRequest::new("victim", std::process::id(), 0, "test");
    for told in [Credentials::none(), Credentials::from_text(&own).unwrap()] {
        let stop = AtomicBool::new(false);
        let joined = ClientLink::join_launched(
            &live.run,
            None,
            Some(told),
            &request,
            WaitPolicy::Block,
            PATIENCE,
            &stop,
        );
        let error = joined.err().expect("the wrong key is refused");
        assert!(matches!(&error, LinkError::Refused(_)), "{error}");
        assert!(error.to_string().contains(arg(&file)), "{error}");
    }
    live.server.signal(Signal::INT);
    live.ends_with(3);
}

#[test]
fn a_run_is_controlled_with_its_key_alone() {
    let live = Live::start("serve", "control-key", &[&ALONE, &ROSTER]);
    let control = |verb| sim_server(&["control", live.run.as_str(), verb]);
    until("the run can be controlled", || control("status").code == Some(0));
    let file = Domain::base().join(live.run.as_str()).join("control-key");
    assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o600);
    let key = fs::read_to_string(&file).unwrap();
    let other = format!("{}\n", "0f".repeat(16));
    for wrong in [Some(other.as_str()), Some("no key"), None] {
        match wrong {
            Some(text) => fs::write(&file, text).unwrap(),
            None => fs::remove_file(&file).unwrap(),
        }
        for verb in ["pause", "stop", "status"] {
            assert_ne!(control(verb).code, Some(0), "{verb} with {wrong:?}");
        }
    }
    fs::write(&file, key).unwrap();
    assert!(control("status").expect(0).stdout.contains("0 of 5"));
    control("stop").expect(0);
    live.ends_with(3);
}

/// What the server's thread is asked to do.
type Job = Box<dyn FnOnce(&mut ServerLink) + Send>;

const RUN_ID: u64 = 77;

fn key() -> TruthKey {
    TruthKey::from_bytes([7; 32])
}

/// A server in a thread of the test, with one estimator and one scorer.
struct Stage {
    estimator: ClientLink,
    scorer: ClientLink,
    run: RunName,
    jobs: Option<Sender<Job>>,
    server: Option<JoinHandle<()>>,
}

impl Stage {
    fn open(tag: &str, check_frames: bool) -> Self {
        let (run, (jobs, asked)) = (fresh_run(tag), channel::<Job>());
        let served = run.clone();
        let server = std::thread::spawn(move || serve(&served, check_frames, &asked));
        let estimator = join(&run, "estimator").unwrap();
        let scorer = join(&run, "scorer").unwrap();
        let mut stage = Self { estimator, scorer, run, jobs: Some(jobs), server: Some(server) };
        let mut ready = 0;
        until("both are ready", || {
            ready += stage.ask(|link| {
                link.take_answers(|received| assert!(received.forged_by.is_none())).unwrap()
            });
            ready == 2
        });
        stage
    }

    /// Has the server's thread do something, and returns the result.
    fn ask<T: Send + 'static>(
        &mut self,
        job: impl FnOnce(&mut ServerLink) -> T + Send + 'static,
    ) -> T {
        let (reply, replied) = channel();
        let job: Job = Box::new(move |link| reply.send(job(link)).unwrap());
        self.jobs.as_ref().unwrap().send(job).unwrap();
        replied.recv().unwrap()
    }

    /// Publishes the frame of a tick, and returns its digest.
    fn publish(&mut self, tick: u64) -> u64 {
        self.ask(move |link| {
            let mut frame = link.loan().unwrap();
            let counts = EncoderCounts { left: 1234, right: 5678 };
            frame.begin(tick, 0.02, counts, Twist::default());
            frame.run_id = RUN_ID;
            frame.seal(&key(), Some(SE2::new(1.0, 2.0, 0.5)));
            let digest = frame.digest();
            link.publish(frame, 0..2).unwrap();
            link.wake_all();
            digest
        })
    }

    /// Changes a byte of the frame with this digest where it is in shared memory,
    /// `from_digest` bytes after the digest.
    fn change(&self, digest: u64, from_digest: usize) {
        let mut changed = 0;
        for path in Domain::traces(&self.run).iter().filter(|path| path.is_file()) {
            let bytes = fs::read(path).unwrap();
            let found = bytes.windows(8).enumerate().filter(|(_, w)| *w == digest.to_le_bytes());
            let file = OpenOptions::new().read(true).write(true).open(path).unwrap();
            for (at, _) in found {
                let byte = [bytes[at + from_digest] ^ 1];
                file.write_all_at(&byte, (at + from_digest) as u64).unwrap();
                changed += 1;
            }
        }
        assert!(changed > 0, "the frame was not found");
    }
}

impl Drop for Stage {
    fn drop(&mut self) {
        drop(self.jobs.take());
        let _ = self.server.take().map(JoinHandle::join);
    }
}

/// The server's thread: lets both in, then does what it is asked to do.
fn serve(run: &RunName, check_frames: bool, asked: &Receiver<Job>) {
    let roster = vec![
        Participant::new("estimator", Role::Estimator),
        Participant::new("scorer", Role::Scorer),
    ];
    let header = header_of(config_of("patrol", &[]), roster);
    let domain = Domain::create(run).unwrap();
    for (slot, p) in header.roster.iter().enumerate() {
        let told = Credentials::new(&key(), slot, p.role.holds_key());
        domain.leave_credentials(&p.name, &told).unwrap();
    }
    let mut link = ServerLink::create(&domain, WaitPolicy::Block, &key()).unwrap();
    let mut joined = 0;
    while joined < 2 {
        let Some(call) = link.next_join().unwrap() else { continue };
        let request = call.request().unwrap();
        let slot = header.roster.iter().position(|p| p.name == request.name).unwrap();
        assert!(link.keys().has_signed_request(&request, slot));
        assert!(!link.keys().has_signed_request(&request, 1 - slot));
        let start = Start::new(&header, slot, &header.roster[slot]);
        let start = Start { run_id: RUN_ID, check_frames, ..start };
        call.reply(&JoinReply::Start(Box::new(start))).unwrap();
        link.wake_all();
        joined += 1;
    }
    asked.iter().for_each(|job| job(&mut link));
}

/// The distance between two fields of a frame, bytes.
fn distance(from: &str, to: &str) -> usize {
    let at = |name: &str| {
        let fields = rusty_contract::frame::FRAME_FIELDS;
        fields.iter().find(|f| f.name == name).unwrap().offset
    };
    at(to) - at(from)
}

#[test]
fn a_frame_that_is_changed_in_shared_memory_is_noticed() {
    // The bytes of the digest itself, and, where frames are checked, all others.
    for (check_frames, field) in [(false, "digest"), (true, "digest"), (true, "left_ticks")] {
        let mut stage = Stage::open("changed", check_frames);
        let digest = stage.publish(0);
        assert_eq!(next(&mut stage.estimator).unwrap().digest(), digest);
        let digest = stage.publish(1);
        stage.change(digest, distance("digest", field));
        let error = next(&mut stage.estimator).err().expect("the change is noticed");
        match field {
            "digest" => assert!(matches!(error, LinkError::Unsigned { tick: 1 }), "{error}"),
            _ => assert!(
                matches!(error, LinkError::Changed { tick: 1, signed, .. } if signed == digest),
                "{error}"
            ),
        }
    }
}

#[test]
fn a_tally_is_noise_without_the_key() {
    let mut stage = Stage::open("tally", false);
    let estimate = SE2::new(4.3, -1.5, 0.75);
    stage.publish(0);
    let answer = Answer::carrying(&Message::Reply(estimate.into()));
    stage.ask(move |link| {
        link.publish_tally(|tally| {
            tally.begin(RUN_ID, 0);
            tally.world_digest = [0xA5; 16];
            tally.push(TallyEntry::answered(answer, 5));
        })
        .unwrap();
    });
    let sealed = stage.scorer.next_tally().unwrap().expect("a scorer gets the tally");
    let mut opened = Tally::default();
    sealed.open_into(&key(), &mut opened);
    assert_eq!(opened.world_digest, [0xA5; 16]);
    assert_eq!(opened.entries()[0].reply(), estimate.into());
    // As everybody can read it.
    for path in Domain::traces(&stage.run).iter().filter(|path| path.is_file()) {
        let bytes = fs::read(path).unwrap();
        assert!(!bytes.windows(16).any(|w| w == [0xA5; 16]), "{}", path.display());
        assert!(!bytes.windows(8).any(|w| w == 4.3f64.to_le_bytes()), "{}", path.display());
    }
}
