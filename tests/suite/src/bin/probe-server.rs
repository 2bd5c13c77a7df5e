//! A server that is killed at an exact moment inside the transport, for tests
//! of the participants. It plays the frames of a log through the link to the
//! log's estimators, which are started by hand, and kills itself.

use std::collections::VecDeque;
use std::path::PathBuf;
use std::time::Duration;

use clap::Parser;
use rustix::process::Signal;
use rusty_contract::answer::Message;
use rusty_contract::log::{LogReader, Read};
use rusty_contract::{Answer, Credentials, JoinReply, Phase, RunName, Start, TruthKey};
use rusty_link::{Domain, ServerLink, WaitPolicy};

#[derive(Parser)]
struct Cli {
    #[arg(long)]
    run: RunName,
    /// Whose frames and estimators
    #[arg(long)]
    log: PathBuf,
    /// When: domain (before any service), services (before anybody is let in),
    /// asked (a request is taken and not answered), ready (before the first
    /// frame), loan (a frame is loaned and half written), sent (it is out),
    /// answer (the first of the answers is taken), answers (all are), last
    /// (the end of run is out)
    #[arg(long)]
    mode: String,
    /// At which tick
    #[arg(long, default_value_t = 10)]
    at: u64,
}

/// Who plays, and when it ends.
struct Play {
    cli: Cli,
    link: ServerLink,
    inbox: VecDeque<Answer>,
    slots: usize,
}

fn main() {
    let cli = Cli::parse();
    let mut log = LogReader::open(&cli.log).unwrap();
    let mut header = log.header().clone();
    header.roster.retain(|p| p.role.answers());
    let domain = Domain::create(&cli.run).unwrap();
    die_if(&cli, "domain");
    let key = TruthKey::from_bytes([7; 32]);
    for (slot, participant) in header.roster.iter().enumerate() {
        let credentials = Credentials::new(&key, slot, false);
        domain.leave_credentials(&participant.name, &credentials).unwrap();
    }
    let link = ServerLink::create(&domain, WaitPolicy::Balanced, &key).unwrap();
    die_if(&cli, "services");
    let mut play = Play { cli, link, inbox: VecDeque::new(), slots: header.roster.len() };
    let run_id = 7;
    play.gather(|name| {
        let slot = header.roster.iter().position(|p| p.name == name).unwrap();
        let start = Start::new(&header, slot, &header.roster[slot]);
        let (server_pid, server_awake_ns) = (std::process::id(), WaitPolicy::Balanced.awake_ns());
        Start { run_id, server_pid, server_awake_ns, ..start }
    });
    die_if(&play.cli, "ready");
    while let Read::Tick(entry) = log.read().unwrap() {
        let now = entry.record.tick == play.cli.at;
        let mut frame = play.link.loan().unwrap();
        entry.record.write_unsealed(&mut frame, header.config.dt_s);
        play.die_at(now, "loan");
        frame.seal(&key, entry.record.pose_in_world());
        frame.run_id = run_id;
        play.link.publish(frame, 0..play.slots).unwrap();
        play.link.wake_all();
        play.die_at(now, "sent");
        for answered in 0..play.slots {
            play.answer();
            play.die_at(now && answered == 0, "answer");
        }
        play.die_at(now, "answers");
    }
    let mut frame = play.link.loan().unwrap();
    frame.end(Phase::Done, header.config.ticks);
    frame.run_id = run_id;
    play.link.publish(frame, 0..play.slots).unwrap();
    die_if(&play.cli, "last");
    panic!("mode {:?} never came about", play.cli.mode);
}

impl Play {
    /// Lets everybody in and waits until all are ready.
    fn gather(&mut self, start: impl Fn(&str) -> Start) {
        let mut joined = 0;
        while joined < self.slots {
            if let Some(call) = self.link.next_join().unwrap() {
                die_if(&self.cli, "asked");
                let name = call.request().unwrap().name;
                call.reply(&JoinReply::Start(Box::new(start(&name)))).unwrap();
                self.link.wake_all();
                joined += 1;
            }
            std::thread::sleep(Duration::from_micros(100));
        }
        for _ in 0..self.slots {
            assert_eq!(self.answer(), Message::Ready);
        }
    }

    fn answer(&mut self) -> Message {
        loop {
            if let Some(answer) = self.inbox.pop_front() {
                return answer.message().unwrap();
            }
            let inbox = &mut self.inbox;
            self.link.take_answers(|received| inbox.push_back(received.answer)).unwrap();
            std::thread::sleep(Duration::from_micros(20));
        }
    }

    fn die_at(&self, now: bool, mode: &str) {
        if now {
            die_if(&self.cli, mode);
        }
    }
}

/// SIGKILL leaves no time for a further step. That there is something to sweep is
/// seen here: after the death any start of any run may sweep it.
fn die_if(cli: &Cli, mode: &str) {
    if cli.mode == mode {
        assert!(!Domain::traces(&cli.run).is_empty(), "{mode}");
        rusty_tests::send_signal(std::process::id(), Signal::KILL);
    }
}
