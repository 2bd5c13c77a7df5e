//! `info`: describe a log or one of its ticks.

use std::collections::BTreeMap;
use std::path::PathBuf;

use anyhow::{Result, bail};
use clap::Args;
use rusty_contract::digest::ObservableDigest;
use rusty_contract::log::{Ending, LogReader, Read, Source, TickRecord};
use rusty_contract::score::seconds;
use rusty_contract::{
    Exit, Frame, LidarConfig, LogHeader, Reply, RunConfig, RunDigest, TruthKey, errln, outln,
};
use rusty_logs::compare;
use serde_json::{Value, json};

use super::WrongUsage;
use super::arguments::Output;

#[derive(Args, Clone, Debug)]
pub struct InfoArgs {
    /// Log to read
    pub log: PathBuf,
    /// Show the tick of this index, counted from 0
    #[arg(long, value_name = "N")]
    pub tick: Option<u64>,
    #[command(flatten)]
    pub output: Output,
}

pub fn run(args: &InfoArgs) -> Result<Exit> {
    match args.tick {
        Some(tick) => one_tick(args, tick),
        None => whole(args),
    }
}

struct Facts {
    header: LogHeader,
    ticks: u64,
    scans: u64,
    /// Ticks with a reading of each small sensor, by its name.
    readings: BTreeMap<&'static str, u64>,
    truths: u64,
    /// First and last.
    times_s: Option<(f64, f64)>,
    damaged: u64,
    digest: RunDigest,
    observable: ObservableDigest,
    ending: Ending,
}

impl Facts {
    fn read(args: &InfoArgs) -> Result<Self> {
        let mut reader = LogReader::open(&args.log)?;
        let header = reader.header().clone();
        let key = TruthKey::from_bytes([0; 32]);
        let (mut digest, mut frame) = (RunDigest::default(), Frame::boxed());
        let (mut ticks, mut scans, mut truths) = (0u64, 0u64, 0u64);
        let mut times_s: Option<(f64, f64)> = None;
        let mut readings = BTreeMap::new();
        let mut observable = ObservableDigest::default();
        let ending = loop {
            match reader.read()? {
                Read::Tick(entry) => {
                    let record = entry.record;
                    record.write_frame(&mut frame, header.config.dt_s, &key);
                    record.absorb(&frame, &mut digest);
                    observable.absorb(&frame);
                    ticks += 1;
                    scans += u64::from(record.ranges_m.is_some());
                    for name in record.readings.get().present().names() {
                        *readings.entry(name).or_default() += 1;
                    }
                    truths += u64::from(record.truth.is_some());
                    let time_s = record.time_s(header.config.dt_s);
                    times_s = Some((times_s.map_or(time_s, |t| t.0), time_s));
                }
                Read::End(ending) => break ending,
            }
        };
        let damaged = reader.damaged();
        Ok(Self {
            header,
            ticks,
            scans,
            readings,
            truths,
            times_s,
            damaged,
            digest,
            observable,
            ending,
        })
    }

    /// Nothing is missing and nothing is damaged.
    fn complete(&self) -> bool {
        match &self.ending {
            Ending::Complete(t) => self.damaged == 0 && t.run_digest == self.digest.run(),
            Ending::Cut { .. } => false,
        }
    }

    fn json(&self, args: &InfoArgs) -> Value {
        let header = &self.header;
        json!({
            "log": args.log.display().to_string(),
            "writer": header.writer,
            "source": header.source,
            "config": header.config,
            "seed": header.seed(),
            "roster": header.roster,
            "on_loss": header.on_loss,
            "ticks": self.ticks,
            "ticks_planned": header.config.ticks,
            "scans": self.scans,
            "readings": self.readings,
            "ticks_with_truth": self.truths,
            "first_time_s": self.times_s.map(|t| t.0),
            "last_time_s": self.times_s.map(|t| t.1),
            "complete": self.complete(),
            "damaged_records": self.damaged,
            "cut": cut(&self.ending),
            "digest": self.digest.run_hex(),
            "world_digest": self.digest.world_hex(),
            "observable_digest": self.observable.hex(),
        })
    }

    fn print(&self) {
        print_header(&self.header);
        let (ticks, planned) = (self.ticks, self.header.config.ticks);
        let (scans, truths) = (self.scans, self.truths);
        outln!("ticks     {ticks} of {planned}, {scans} with a scan, {truths} with a known truth");
        if !self.readings.is_empty() {
            let counts = self.readings.iter().map(|(name, n)| format!("{name} {n}"));
            outln!("readings  ticks with {}", counts.collect::<Vec<_>>().join(", "));
        }
        if let Some((first, last)) = self.times_s {
            outln!("time      {} s to {} s", seconds(first), seconds(last));
        }
        match cut(&self.ending) {
            Some(how) => outln!("complete  no: {how}"),
            None if self.damaged > 0 => {
                outln!("complete  no: the checksums of {} records fail", self.damaged);
            }
            None if !self.complete() => {
                outln!("complete  no: its digest is not that of its records");
            }
            None => outln!("complete  yes"),
        }
        outln!("digest    {}", self.digest.run_hex());
        outln!("seen      {} (observable digest)", self.observable.hex());
    }
}

fn whole(args: &InfoArgs) -> Result<Exit> {
    let facts = Facts::read(args)?;
    args.output.print_with(&facts.json(args), || facts.print());
    Ok(if facts.complete() { Exit::Done } else { Exit::Lost })
}

fn cut(ending: &Ending) -> Option<String> {
    match ending {
        Ending::Complete(_) => None,
        Ending::Cut { ticks, at_byte, problem } => {
            Some(format!("cut after {ticks} complete ticks, at byte {at_byte}: {problem}"))
        }
    }
}

fn print_header(header: &LogHeader) {
    let config = &header.config;
    match header.seed() {
        Some(seed) => outln!("seed      {seed}"),
        None if header.is_blind() => outln!("seed      none: the log is blind"),
        None => outln!("seed      none: recorded by a robot"),
    }
    outln!("scenario  {}", config.scenario);
    outln!("writer    {}", header.writer);
    match &header.source {
        Source::Recorded { format, file, remarks, findings } => {
            outln!("source    {file} ({format})");
            for remark in remarks {
                outln!("          {remark}");
            }
            for finding in findings {
                outln!("finding   {finding}");
            }
        }
        Source::Blind { of, ticks, figures_known, .. } => {
            outln!("source    a {of} of {ticks} ticks, sealed: truth and script are in its key");
            match header.known_world() {
                Some(world) => outln!("world     {} ({} walls)", world.name, world.walls.len()),
                None => outln!("world     hidden"),
            }
            match header.known_start() {
                Some(p) => outln!("start     x {} m, y {} m, θ {} rad", p.x(), p.y(), p.theta()),
                None => outln!("start     hidden"),
            }
            if !figures_known {
                outln!("sensors   with the figures of their data sheets");
            }
        }
        Source::Simulated | Source::Forked { .. } => {
            if let Source::Forked { at_tick, before } = &header.source {
                let (motion, l) = (motion(before), &before.lidar);
                outln!("source    forked at tick {at_tick}; what follows holds from there on");
                outln!(
                    "before    seed {}, {motion}, range {} m, dropout {}",
                    before.seed,
                    l.range_std_m,
                    l.dropout
                );
            }
            let walls = config.world.walls.len();
            outln!("world     {} ({walls} walls)", config.world.name);
            outln!("script    {}", config.script.kind());
            outln!("robot     {}", motion(config));
        }
    }
    outln!("time step {} s, {}", seconds(config.dt_s), scans(header));
    let (lidar, glass) = (&config.lidar, glass(&config.lidar));
    outln!("LiDAR     {} beams, up to {} m{glass}", lidar.beams, lidar.range_max_m);
    for p in &header.roster {
        let sheet = match p.role.holds_key() {
            true => String::new(),
            false => format!(", data sheet {}", p.data_sheet),
        };
        outln!("roster    {} ({}{sheet}){}", p.name, p.role, command(&p.command));
    }
}

/// How often there is a scan.
fn scans(header: &LogHeader) -> String {
    match (header.config.scan_every, &header.source) {
        (0, Source::Recorded { .. }) => "scans where the recording has them".to_owned(),
        (0, Source::Blind { .. }) => "scans where the log has them".to_owned(),
        (0, _) => "no scans".to_owned(),
        (every, _) => format!("a scan every {every} ticks"),
    }
}

/// Which beams see glass, if not all do.
fn glass(lidar: &LidarConfig) -> String {
    let all_rad = LidarConfig::default().glass_visible_rad;
    let within_deg = lidar.glass_visible_rad.to_degrees();
    match lidar.glass_visible_rad < all_rad {
        true => format!(", sees glass within {within_deg:.0}° of its perpendicular"),
        false => String::new(),
    }
}

/// Returns the errors of the motion of a robot.
fn motion(config: &RunConfig) -> String {
    let robot = &config.robot;
    format!(
        "slip {}, right wheel {:+} %, track {:+} %",
        config.slip_in_words(" per tick"),
        100.0 * robot.radius_bias_right,
        100.0 * robot.track_bias
    )
}

/// Returns the command of a participant on one line.
fn command(words: &[String]) -> String {
    let line = words.join(" ").replace('\n', "\\n");
    if words.is_empty() { line } else { format!(", started as {line}") }
}

fn one_tick(args: &InfoArgs, wanted: u64) -> Result<Exit> {
    let mut reader = LogReader::open(&args.log)?;
    let header = reader.header().clone();
    let mut ticks = 0;
    loop {
        match reader.read()? {
            Read::Tick(entry) if entry.record.tick == wanted => {
                let (record, intact) = (&entry.record, entry.intact);
                args.output.print_with(&tick_json(&header, record, intact), || {
                    print_tick(&header, record, intact);
                });
                return Ok(if intact { Exit::Done } else { Exit::Lost });
            }
            Read::Tick(_) => ticks += 1,
            Read::End(ending) => {
                if let Some(how) = cut(&ending) {
                    errln!("{}: {how}", args.log.display());
                }
                let log = args.log.display();
                bail!(WrongUsage(format!(
                    "{log} has no tick {wanted}: it has {ticks} ticks, numbered from 0"
                )));
            }
        }
    }
}

fn tick_json(header: &LogHeader, record: &TickRecord, intact: bool) -> Value {
    let answers: Vec<Value> = header
        .answering()
        .zip(&record.replies)
        .map(|(p, reply)| reply_json(&p.name, reply))
        .collect();
    json!({
        "tick": record.tick,
        "time_s": record.time_s(header.config.dt_s),
        "left_ticks": record.ticks.left,
        "right_ticks": record.ticks.right,
        "encoders": { "left": record.ticks.left, "right": record.ticks.right },
        "command": record.command,
        "truth": record.truth.map(|[x, y, theta]| json!({ "x_m": x, "y_m": y, "theta_rad": theta })),
        "ranges": record.ranges_m,
        "readings": record.readings.get().named().collect::<BTreeMap<_, _>>(),
        "answers": answers,
        "intact": intact,
    })
}

fn reply_json(name: &str, reply: &Reply) -> Value {
    json!({
        "name": name,
        "kind": compare::kind(reply),
        "pose": reply.estimate().map(|e| e.pose_in_world),
        "covariance": reply.estimate().and_then(|e| e.covariance),
        "innovation": reply.estimate().and_then(|e| e.innovation),
        "command": reply.command(),
    })
}

fn print_tick(header: &LogHeader, record: &TickRecord, intact: bool) {
    if !intact {
        outln!("the checksum of this record fails: its values are suspect");
    }
    outln!("tick      {}", record.tick);
    outln!("time      {} s", seconds(record.time_s(header.config.dt_s)));
    outln!("encoders  left {}, right {}", record.ticks.left, record.ticks.right);
    outln!("command   v {} m/s, ω {} rad/s", record.command.v_m_s, record.command.omega_rad_s);
    match record.truth {
        Some([x, y, theta]) => outln!("truth     x {x} m, y {y} m, θ {theta} rad"),
        None => outln!("truth     unknown"),
    }
    for (p, reply) in header.answering().zip(&record.replies) {
        outln!("answer    {}: {}", p.name, compare::reply_text(reply));
    }
    for (name, number) in record.readings.get().named() {
        outln!("reading   {name} {number}");
    }
    match &record.ranges_m {
        Some(ranges) => outln!("ranges    {ranges:?}"),
        None => outln!("ranges    no scan in this tick"),
    }
}
