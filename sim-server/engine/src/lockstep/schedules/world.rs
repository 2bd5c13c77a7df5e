//! Everyone outside the machine, and the books they keep.

use rusty_contract::answer::Message;
use rusty_contract::{Answer, JoinRequest, OnLoss, Participant, Phase, Reply, Role};
use rusty_geometry::SE2;

use super::super::{Lockstep, Rules, Step};
use super::{Dice, Played};

const RUN: u64 = 77;

/// Something that happens while the machine waits.
#[derive(Clone, Debug)]
pub enum Event {
    /// A request to join, now and then of another version or by a stranger.
    Join(usize, u64),
    /// The ports are open.
    Ready(usize),
    /// The answer that is asked for.
    Answer(usize),
    /// Another answer of the same tick.
    Double(usize),
    /// An answer that is not asked for: what is wrong with it is a number.
    Wrong(usize, u64),
    /// The leave message of a client.
    Leave(usize),
    /// The client says that it failed.
    Failed(usize),
    /// The kernel says that the process has ended.
    Died(usize),
    /// Ctrl-C.
    Interrupt,
    /// Only time goes on, ns.
    Pass(u64),
    /// Time goes on for as long as the machine is content to wait, or longer.
    Timeout(u64),
}

impl Event {
    pub(super) fn draw(dice: &mut Dice) -> Self {
        let slot = dice.below(4) as usize;
        match dice.below(64) {
            0..5 => Self::Join(slot, dice.below(12)),
            5..11 => Self::Ready(slot),
            11..14 => Self::Double(slot),
            14..17 => Self::Wrong(slot, dice.below(40)),
            17 => Self::Leave(slot),
            18 => Self::Failed(slot),
            19..22 => Self::Died(slot),
            22 if dice.below(4) == 0 => Self::Interrupt,
            22..26 => Self::Pass(dice.below(400)),
            26 => Self::Timeout(dice.below(3) * 500),
            _ => Self::Answer(slot),
        }
    }
}

/// What the books say of a participant.
#[derive(Clone, Debug, Default)]
struct Book {
    ticket: u32,
    /// It was let in and is neither lost nor away.
    seated: bool,
    ready: bool,
    lost: bool,
    away: bool,
    /// Its first right answer to the tick that is open.
    reply: Option<Reply>,
    /// The next tick it must be given again, and how many in all.
    again: Option<(u64, u64)>,
    /// The tick that was given again last and waits for its answer.
    given: Option<u64>,
}

impl Book {
    fn is_coming_back(&self) -> bool {
        self.away || self.again.is_some()
    }
}

pub(super) enum Next {
    Busy,
    Idle { until_ns: u64 },
    Over,
}

pub(super) struct World {
    machine: Lockstep,
    pub(super) now_ns: u64,
    policy: OnLoss,
    ticks: u64,
    roster: Vec<Participant>,
    books: Vec<Book>,
    /// Ticks that are closed, and whether the next one is open.
    closed: u64,
    open: bool,
    ended: Option<Phase>,
    stopped: bool,
    tickets: u32,
    played: Played,
    /// A lie, for the test of the test.
    pub(super) false_books: bool,
}

fn digest(tick: u64) -> u64 {
    1_000 + tick
}

/// What a deterministic participant says.
fn says(slot: usize, tick: u64) -> Reply {
    SE2::new(slot as f64, tick as f64, 0.0).into()
}

impl World {
    pub(super) fn new(seed: u64) -> Self {
        let mut dice = Dice(!seed);
        let roles = [Role::Estimator, Role::Driver, Role::Logger, Role::Observer];
        let roster: Vec<Participant> = (0..1 + dice.below(4))
            .map(|i| {
                let role = roles[dice.below(4) as usize];
                let mut participant = Participant::new(&format!("p{i}"), role);
                participant.required = role != Role::Estimator || dice.below(5) > 0;
                participant
            })
            .collect();
        let policy = [OnLoss::Abort, OnLoss::Continue, OnLoss::Restart, OnLoss::Restart]
            [dice.below(4) as usize];
        let ticks = 1 + dice.below(8);
        let rules = Rules {
            run_id: RUN,
            ticks,
            on_loss: policy,
            join_timeout_ns: 1_500,
            answer_timeout_ns: 2_000,
            leave_timeout_ns: 5_000,
            early_leave_timeout_ns: 2_000,
            slow_after_ns: 300,
        };
        let mut world = Self {
            machine: Lockstep::new(rules, &roster, 1),
            now_ns: 1,
            policy,
            ticks,
            books: vec![Book::default(); roster.len()],
            roster,
            closed: 0,
            open: false,
            ended: None,
            stopped: false,
            tickets: 0,
            played: Played::default(),
            false_books: false,
        };
        if dice.below(8) > 0 {
            for slot in 0..world.roster.len() {
                world.happen(&Event::Join(slot, 0), 0);
                world.happen(&Event::Ready(slot), 0);
            }
        }
        world
    }

    pub(super) fn played(&mut self) -> Played {
        self.played.ticks = self.closed;
        self.played.done = self.ended == Some(Phase::Done);
        std::mem::take(&mut self.played)
    }

    fn awaited(&self) -> impl Iterator<Item = &Book> {
        self.books.iter().zip(&self.roster).filter(|(_, p)| p.is_awaited()).map(|(b, _)| b)
    }

    /// One step of the machine, held against the books.
    pub(super) fn step(&mut self) -> Result<Next, String> {
        let step = self.machine.next(self.now_ns, |_| String::new());
        match step {
            Step::Wait { until_ns } => {
                self.check_wait(until_ns)?;
                return Ok(Next::Idle { until_ns });
            }
            Step::Finished => {
                let left = self.machine.slots().iter().any(|s| s.awaited && s.is_present());
                require(self.ended.is_some() && !left, "it finishes too early")?;
                return Ok(Next::Over);
            }
            Step::Publish(tick) => self.publish(tick)?,
            Step::Close(tick) => self.close(tick)?,
            Step::End(phase) => self.end(phase)?,
            Step::Feed { slot, tick } => self.feed(slot, tick)?,
            Step::Echo { slot, tick, reply } => {
                require(reply.same_bits(&says(slot, tick)), "an echo is not what was said")?;
            }
            Step::Restart(loss) => {
                let book = &mut self.books[loss.slot];
                // One that was started again may die again before it joins.
                require(self.policy == OnLoss::Restart && !book.lost, "no return")?;
                *book = Book { away: true, reply: book.reply, ..Book::default() };
            }
            Step::Lost(loss) => {
                let book = &mut self.books[loss.slot];
                require(!book.lost, "lost twice")?;
                *book = Book { lost: true, reply: book.reply, ..Book::default() };
                self.played.losses += 1;
            }
            Step::Slow { slot, .. } => {
                require(self.machine.slots()[slot].is_present(), "who is not there is slow")?;
            }
        }
        Ok(Next::Busy)
    }

    fn check_wait(&self, until_ns: u64) -> Result<(), String> {
        require(until_ns > self.now_ns, "it waits for the past")?;
        require(until_ns < self.now_ns + 1_000_000, "it waits without a bound")?;
        let for_whom = if self.ended.is_some() {
            self.machine.slots().iter().any(|s| s.awaited && s.is_present())
        } else if self.open {
            self.awaited().any(|b| !b.lost && (b.reply.is_none() || b.is_coming_back()))
        } else {
            self.awaited().any(|b| !b.lost && (!b.ready || b.is_coming_back()))
        };
        require(for_whom, "it waits for nobody")
    }

    fn publish(&mut self, tick: u64) -> Result<(), String> {
        require(tick == self.closed && !self.open && self.ended.is_none(), "a tick out of turn")?;
        let there = |b: &Book| b.lost || (b.ready && !b.is_coming_back());
        require(self.awaited().all(there), "a tick without somebody it must wait for")?;
        if let Some(Phase::Aborted) = self.ended {
            return Err("a tick after the end".to_owned());
        }
        self.books.iter_mut().for_each(|b| b.reply = None);
        self.open = true;
        self.machine.published(digest(tick), self.now_ns);
        Ok(())
    }

    fn close(&mut self, tick: u64) -> Result<(), String> {
        require(tick == self.closed && self.open, "closed out of turn")?;
        let done = |b: &Book| b.lost || (b.reply.is_some() && !b.is_coming_back());
        require(self.awaited().all(done), "closed before all had answered")?;
        for (slot, reply) in self.machine.replies() {
            let first = self.books[slot].reply.unwrap_or(Reply::Missing);
            require(reply.same_bits(&first), "the reply is not the first one given")?;
        }
        self.closed += 1;
        self.open = false;
        Ok(())
    }

    fn end(&mut self, phase: Phase) -> Result<(), String> {
        require(phase != Phase::Done || self.closed == self.ticks, "done too early")?;
        let may_abort = self.books.iter().any(|b| b.lost) && self.policy != OnLoss::Continue;
        require(phase != Phase::Aborted || may_abort, "aborted without a reason")?;
        require(phase != Phase::Interrupted || self.stopped, "interrupted by nobody")?;
        require(self.ended.is_none_or(|before| before == phase), "two endings")?;
        self.ended = Some(phase);
        self.open = false;
        self.machine.published(0, self.now_ns);
        Ok(())
    }

    fn feed(&mut self, slot: usize, tick: u64) -> Result<(), String> {
        let book = &mut self.books[slot];
        let right = book.ready && book.given.is_none();
        require(right && book.again.is_some_and(|(next, _)| next == tick), "fed out of turn")?;
        book.given = Some(tick);
        self.played.fed += 1;
        self.machine.fed(slot, digest(tick), self.now_ns);
        Ok(())
    }

    /// Lets something happen.
    pub(super) fn happen(&mut self, event: &Event, until_ns: u64) {
        let n = self.roster.len();
        match *event {
            Event::Join(slot, wrong) => self.join(slot % n, wrong),
            Event::Ready(slot) => {
                let book = &mut self.books[slot % n];
                book.ready |= book.seated;
                if book.ready && book.again.is_some_and(|(_, of)| of == 0) {
                    book.again = None;
                }
                self.send(slot % n, 0, 0, &Message::Ready);
            }
            Event::Answer(slot) => self.answer(slot % n),
            Event::Double(slot) => {
                let slot = slot % n;
                // Who has not answered yet would be giving its first answer.
                if self.books[slot].reply.is_some() && !self.books[slot].is_coming_back() {
                    let other = Reply::from(SE2::new(-1.0, -1.0, -1.0));
                    self.send(slot, self.closed, digest(self.closed), &Message::Reply(other));
                }
            }
            Event::Wrong(slot, how) => self.wrong(slot % n, how),
            Event::Leave(slot) => self.send(slot % n, 0, 0, &Message::Leave),
            Event::Failed(slot) => self.send(slot % n, 0, 0, &Message::Failed),
            Event::Died(slot) => self.machine.died(slot % n, "killed"),
            Event::Interrupt => {
                self.stopped = true;
                self.machine.interrupt();
            }
            Event::Pass(ns) => self.now_ns += ns,
            Event::Timeout(more_ns) => self.now_ns = until_ns.saturating_add(more_ns),
        }
    }

    fn join(&mut self, slot: usize, wrong: u64) {
        let mut request = JoinRequest::new(&self.roster[slot].name, 100, 0, "test");
        match wrong {
            9 => request.protocol ^= 1,
            10 => request.layout ^= 1,
            11 => request.name = "nobody".to_owned(),
            _ => {}
        }
        self.tickets += 1;
        if self.machine.join(&request, self.tickets).is_err() {
            return;
        }
        let published = self.closed + u64::from(self.open);
        let book = &mut self.books[slot];
        if book.away {
            self.played.returns += 1;
            book.again = Some((0, published));
        }
        (book.away, book.seated, book.ready, book.ticket) = (false, true, false, self.tickets);
    }

    /// The right answer to whatever was asked.
    fn answer(&mut self, slot: usize) {
        let (open, closed) = (self.open, self.closed);
        let book = &mut self.books[slot];
        let tick = book.given.unwrap_or(closed);
        let counts = book.ready
            && self.roster[slot].is_awaited()
            && (book.again.is_none() || book.given.is_some());
        if let (Some((next, of)), Some(_)) = (book.again, book.given.take()) {
            book.again = (next + 1 < of).then_some((next + 1, of));
        }
        if counts && open && tick == closed && self.ended.is_none() {
            book.reply = book.reply.or(Some(says(slot, tick)));
        }
        self.send(slot, tick, digest(tick), &Message::Reply(says(slot, tick)));
    }

    fn wrong(&mut self, slot: usize, how: u64) {
        let tick = self.books[slot].given.unwrap_or(self.closed);
        let reply = Message::Reply(Reply::Abstain);
        let mut answer = self.compose(slot, tick, digest(tick), &reply);
        match how {
            0..8 => answer.tick = tick.wrapping_sub(1 + how % 2),
            8..10 => answer.tick = tick + 1 + how % 2,
            10..12 => answer.digest_seen ^= how,
            12..22 => answer.run_id ^= how,
            22..32 => answer.ticket = answer.ticket.wrapping_add(1 + how as u32 % 2),
            32..36 => answer.participant = how as u32 * 1_000_000,
            36 => {
                let nan = Reply::from(SE2::new(f64::NAN, 0.0, 0.0));
                answer = self.compose(slot, tick, digest(tick), &Message::Reply(nan));
            }
            _ => {
                // A kind that there is not: bytes 44 to 48.
                bytemuck::bytes_of_mut(&mut answer)[44..48].fill(how as u8);
            }
        }
        if self.false_books && how < 8 && self.open && self.books[slot].ready {
            self.books[slot].reply.get_or_insert(Reply::Abstain);
        }
        self.machine.answer(&answer, self.now_ns);
    }

    fn compose(&self, slot: usize, tick: u64, digest_seen: u64, message: &Message) -> Answer {
        let ticket = self.books[slot].ticket;
        let mut answer = Answer::carrying(message);
        (answer.run_id, answer.participant, answer.ticket) = (RUN, slot as u32, ticket);
        (answer.tick, answer.digest_seen) = (tick, digest_seen);
        answer
    }

    fn send(&mut self, slot: usize, tick: u64, digest_seen: u64, message: &Message) {
        let answer = self.compose(slot, tick, digest_seen, message);
        self.machine.answer(&answer, self.now_ns);
    }
}

fn require(holds: bool, promise: &str) -> Result<(), String> {
    if holds { Ok(()) } else { Err(promise.to_owned()) }
}

impl std::fmt::Display for World {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} ticks, on loss {:?}:", self.ticks, self.policy)?;
        for p in &self.roster {
            write!(f, " {} ({}, {})", p.name, p.role, if p.required { "required" } else { "not" })?;
        }
        Ok(())
    }
}
