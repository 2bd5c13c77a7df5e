//! Apps with the protocol of Foxglove: what they read, that they drive where they may, and
//! that they cost a run nothing.

use std::collections::BTreeMap;
use std::net::TcpStream;

use rusty_contract::Log;
use rusty_geometry::Twist;
use rusty_ros::messages::{LaserScan, OccupancyGrid, PoseStamped, TwistStamped};
use rusty_ros::{RosMessage as _, from_cdr, messages};
use rusty_tests::viewed::Viewed;
use rusty_tests::*;
use tungstenite::client::IntoClientRequest as _;
use tungstenite::{Error, HandshakeError, Message, WebSocket};

use crate::Opened as _;

/// An app.
pub struct AppClient {
    socket: WebSocket<TcpStream>,
    pub subprotocol: String,
    /// Topic of each channel, and of each subscription: they have the same numbers.
    topics: BTreeMap<u32, String>,
    session: String,
    status: Vec<String>,
}

/// A message: topic (empty of a time), time, ns, and content.
struct Received {
    topic: String,
    time_ns: u64,
    content: Vec<u8>,
}

impl AppClient {
    /// Connects, or returns the status of the refusal.
    pub fn connect(address: &str, origin: Option<&str>, protocols: &str) -> Result<Self, u16> {
        let mut request = address.into_client_request().unwrap();
        let port = request.uri().port_u16().unwrap();
        let headers = request.headers_mut();
        headers.insert("Sec-WebSocket-Protocol", protocols.parse().unwrap());
        origin.map(|origin| headers.insert("Origin", origin.parse().unwrap()));
        let stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
        stream.set_read_timeout(Some(WATCHDOG)).unwrap();
        match tungstenite::client(request, stream) {
            Ok((socket, response)) => {
                let subprotocol = response.headers()["Sec-WebSocket-Protocol"].to_str().unwrap();
                let subprotocol = subprotocol.to_owned();
                let (topics, session, status) = (BTreeMap::new(), String::new(), Vec::new());
                Ok(Self { socket, subprotocol, topics, session, status })
            }
            Err(HandshakeError::Failure(Error::Http(response))) => Err(response.status().as_u16()),
            Err(e) => panic!("{e}"),
        }
    }

    pub fn open(address: &str) -> Self {
        let mut app = Self::connect(address, None, "foxglove.sdk.v1").unwrap();
        while app.topics.is_empty() {
            assert!(app.read().is_none());
        }
        app
    }

    fn ask(&mut self, request: &Value) {
        self.socket.send(Message::text(request.to_string())).unwrap();
    }

    fn publish(&mut self, channel: u32, content: &[u8]) {
        let bytes = [&[1], &channel.to_le_bytes()[..], content].concat();
        self.socket.send(Message::binary(bytes)).unwrap();
    }

    fn subscribe(&mut self, topics: &[&str]) {
        let wanted = self.topics.iter().filter(|(_, topic)| topics.contains(&&***topic));
        let wanted: Vec<Value> =
            wanted.map(|(id, _)| json!({ "id": id, "channelId": id })).collect();
        assert_eq!(wanted.len(), topics.len());
        self.ask(&json!({ "op": "subscribe", "subscriptions": wanted }));
    }

    /// Reads a message; `None` of one in JSON, of which it keeps what it tells.
    fn read(&mut self) -> Option<Received> {
        let bytes = match self.socket.read().expect("a message") {
            Message::Binary(bytes) => bytes,
            Message::Text(text) => {
                self.take(&serde_json::from_str(&text).unwrap());
                return None;
            }
            other => panic!("{other:?}"),
        };
        let number = |at: usize| u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap());
        let (topic, time_ns, content) = match bytes[0] {
            1 => {
                let id = u32::from_le_bytes(bytes[1..5].try_into().unwrap());
                (self.topics[&id].clone(), number(5), bytes[13..].to_vec())
            }
            2 => (String::new(), number(1), Vec::new()),
            other => panic!("opcode {other}"),
        };
        Some(Received { topic, time_ns, content })
    }

    fn take(&mut self, message: &Value) {
        let ids = |key: &str| message[key].as_array().unwrap().iter();
        match message["op"].as_str().unwrap() {
            "serverInfo" => self.session = text(message, "sessionId").to_owned(),
            "status" => self.status.push(text(message, "message").to_owned()),
            "unadvertise" => ids("channelIds")
                .for_each(|id| drop(self.topics.remove(&(id.as_u64().unwrap() as u32)))),
            "advertise" => {
                for channel in ids("channels") {
                    assert_eq!(
                        (&channel["encoding"], &channel["schemaEncoding"]),
                        (&json!("cdr"), &json!("ros2msg"))
                    );
                    let id = channel["id"].as_u64().unwrap() as u32;
                    self.topics.insert(id, text(channel, "topic").to_owned());
                }
            }
            other => panic!("{other}"),
        }
    }

    fn until(&mut self, mut is_it: impl FnMut(&Received) -> bool) -> Received {
        loop {
            if let Some(received) = self.read().filter(&mut is_it) {
                return received;
            }
        }
    }

    /// Waits until its requests were carried out: the answer to a subscription.
    fn settle(&mut self) {
        self.subscribe(&["/tf_static"]);
        self.until(|received| received.topic == "/tf_static");
        let id = *self.topics.iter().find(|(_, topic)| *topic == "/tf_static").unwrap().0;
        self.ask(&json!({ "op": "unsubscribe", "subscriptionIds": [id] }));
    }
}

#[test]
fn an_app_reads_the_ticks_of_a_log_and_follows_the_page() {
    let (_out, log) = logged("app", &["--ticks", "60"]);
    let records = Log::load(&log).unwrap().records;
    let end_ns = 60 * 20_000_000;
    let viewed = Viewed::view(&[arg(&log)]);
    let (mut page, mut app) = (viewed.page(), AppClient::open(&viewed.foxglove()));
    let first = app.session.clone();
    app.until(|received| received.topic.is_empty() && received.time_ns == end_ns);
    page.ask(&json!({ "do": "pause" }));
    page.ask(&json!({ "do": "seek", "tick": 0 }));
    while app.session == first || app.topics.is_empty() {
        app.read();
    }
    app.subscribe(&["/scan", "/cmd_vel", "/truth/pose", "/map", "/dead_reckoning/pose"]);
    // A log that is paused has its tick and its map.
    let map = app.until(|received| received.topic == "/map");
    assert!(from_cdr::<OccupancyGrid>(&map.content).unwrap().data.contains(&100));
    page.ask(&json!({ "do": "pace", "factor": 4.0 }));
    page.ask(&json!({ "do": "resume" }));
    let mut all: BTreeMap<(String, u64), Vec<u8>> = BTreeMap::new();
    app.until(|received| {
        let Received { topic, time_ns, content } = received;
        let is_last = topic == "/truth/pose" && *time_ns == end_ns;
        assert!(
            all.insert((topic.clone(), *time_ns), content.clone()).is_none() || topic.is_empty()
        );
        is_last
    });
    let count = |topic: &str| all.keys().filter(|(name, _)| name == topic).count();
    assert_eq!(
        ["/cmd_vel", "/truth/pose", "/dead_reckoning/pose", "/odom"].map(count),
        [60, 60, 60, 0]
    );
    assert_eq!(count("/scan"), records.iter().filter(|r| r.ranges_m.is_some()).count());
    for record in &records {
        let of = |topic: &str| all.get(&(topic.to_owned(), (record.tick + 1) * 20_000_000));
        let command: TwistStamped = from_cdr(of("/cmd_vel").unwrap()).unwrap();
        assert_eq!(command.twist, record.command.into());
        let truth: PoseStamped = from_cdr(of("/truth/pose").unwrap()).unwrap();
        assert_eq!(truth.pose, record.pose_in_world().unwrap().into());
        let scan = of("/scan").map(|bytes| from_cdr::<LaserScan>(bytes).unwrap().ranges);
        assert_eq!(scan, record.ranges_m.as_deref().map(as_ros));
    }
}

/// Ranges as a scan of ROS has them: without a return infinite.
fn as_ros(ranges_m: &[f64]) -> Vec<f32> {
    let of = |range_m: &f64| if *range_m < 8.0 { *range_m as f32 } else { f32::INFINITY };
    ranges_m.iter().map(of).collect()
}

#[test]
fn the_client_of_foxglove_reads_every_channel() {
    let Some(packages) = npm::packages() else { return };
    let (_out, log) = logged("npm", &["--ticks", "60", "--seed", "3"]);
    let records = Log::load(&log).unwrap().records;
    let viewed = Viewed::view(&[arg(&log)]);
    let script = repository().join("tests/suite/tests/view/foxglove.js");
    let mut node = Command::new("node");
    node.arg(script).args([&viewed.foxglove(), "1200000000"]);
    let output = node.env("NODE_PATH", packages.join("node_modules")).output().unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(found["subprotocol"], "foxglove.sdk.v1");
    assert_eq!((&found["info"]["capabilities"], &found["status"]), (&json!(["time"]), &json!([])));
    let counts = &found["counts"];
    for topic in ["/map", "/markers", "/tf_static", "/tf", "/odom", "/scan_points"] {
        assert!(counts[topic].as_u64() > Some(0), "{topic}: {counts}");
    }
    let scans = found["scans"].as_object().unwrap();
    assert!(scans.len() > 6, "{counts}");
    for (time_ns, ranges) in scans {
        let tick = time_ns.parse::<usize>().unwrap() / 20_000_000 - 1;
        let range = |range: &Value| range.as_f64().map_or(f32::INFINITY, |range| range as f32);
        let ranges: Vec<f32> = ranges.as_array().unwrap().iter().map(range).collect();
        assert_eq!(ranges, as_ros(records[tick].ranges_m.as_deref().unwrap()), "tick {tick}");
    }
}

#[test]
fn an_app_drives_where_it_may_and_a_dead_man_stops_it() {
    let (run, out) = (fresh_run("teleop"), folder());
    let scenario = repository().join("clients/viewer/scenarios/drive.toml");
    let args = [arg(&scenario), "--ticks", "100000"];
    let viewed = Viewed::launch(&run, out.path(), &[&args]);
    let address = viewed.foxglove();
    let (view_only, _) = address.split_once("&drive=").unwrap();
    let mut page = viewed.page();
    page.until(|m| m["state"] == "running");
    page.ask(&json!({ "do": "step", "ticks": 20 }));
    page.until(|m| m["state"] == "paused");
    let (mut other, mut driver) = (AppClient::open(view_only), AppClient::open(&address));
    let twist = |v_m_s, omega_rad_s| messages::Twist::from(Twist { v_m_s, omega_rad_s });
    let channel = |id: u32, name: &str, encoding: &str| json!({ "id": id, "topic": "/cmd_vel", "encoding": encoding, "schemaName": name });
    let channels = [
        channel(5, "geometry_msgs/Twist", "cdr"),
        channel(6, "geometry_msgs/msg/TwistStamped", "json"),
    ];
    let advertise = json!({ "op": "advertise", "channels": channels });
    let status = ["control", run.as_str(), "status", "--json"];
    let ticks = || sim_server(&status).expect(0).json()["ticks_done"].as_u64().unwrap();
    let mut drive = |app: &mut AppClient, channel: u32, content: &[u8]| {
        app.ask(&advertise);
        app.publish(channel, content);
        app.settle();
        let before = ticks();
        page.ask(&json!({ "do": "step", "ticks": 40 }));
        until("40 ticks", || ticks() == before + 40);
    };
    drive(&mut other, 5, &twist(0.5, 0.0).to_cdr().unwrap());
    assert!(other.status.len() == 2 && other.status[0].contains("drive="), "{:?}", other.status);
    drive(&mut driver, 5, &twist(0.25, -0.5).to_cdr().unwrap());
    // More than the robot can do.
    let fast = json!({ "header": {}, "twist": twist(9.0, 0.25) });
    drive(&mut driver, 6, fast.to_string().as_bytes());
    assert_eq!(driver.status, Vec::<String>::new());
    assert_eq!(sim_server(&["control", run.as_str(), "stop"]).code, Some(0));
    drop((page, other, driver));
    let (_, errors) = viewed.ends_with(3);
    assert!(errors.contains(&format!("\nfoxglove {address}\n")), "{errors}");
    let log = Log::load(&out.at("run.log")).unwrap();
    let mut commands: Vec<[f64; 2]> =
        log.records.iter().map(|r| [r.command.v_m_s, r.command.omega_rad_s]).collect();
    commands.retain(|command| *command != [0.0; 2]);
    assert_eq!(commands, [vec![[0.25, -0.5]; 25], vec![[0.6, 0.25]; 25]].concat());
}

#[test]
fn apps_that_read_stand_still_or_are_killed_change_no_bit_of_a_run() {
    let run_args = ["--ticks", "300", "--seed", "5"];
    let (calm, out, run) = (folder(), folder(), fresh_run("apps"));
    let report = launch("calm", calm.path(), &run_args);
    let viewed = Viewed::launch(&run, out.path(), &[&run_args, &["--pace", "4"]]);
    let open = || {
        let mut app = AppClient::open(&viewed.foxglove());
        let topics: Vec<String> = app.topics.values().cloned().collect();
        app.subscribe(&topics.iter().map(String::as_str).collect::<Vec<_>>());
        app
    };
    let (mut reading, stalled, mut killed) = (open(), open(), open());
    killed.until(|received| received.topic == "/scan");
    // Without a closing frame of the protocol.
    killed.socket.get_mut().shutdown(std::net::Shutdown::Both).unwrap();
    let live = reading.session.clone();
    let mut scans = 0;
    while reading.session == live {
        scans += usize::from(reading.read().is_some_and(|it| it.topic == "/scan"));
    }
    assert!(scans > 10, "{scans}");
    drop((reading, stalled, killed));
    let (output, errors) = viewed.ends_with(0);
    let shown: Value = serde_json::from_str(&output).unwrap();
    assert_eq!(shown["digest"], report["digest"], "{errors}");
    assert_eq!(fs::read(out.at("run.log")).unwrap(), fs::read(calm.at("run.log")).unwrap());
    nothing_left(&run);
}

#[test]
fn without_the_key_an_app_gets_neither_truth_nor_map_nor_answers() {
    let live = Live::start("launch", "unshown", &[&["--ticks", "300", "--paused"]]);
    until("the run can be controlled", || live.control(&["status"]));
    let viewed = Viewed::view(&["--run", live.run.as_str()]);
    let mut app = AppClient::open(&viewed.foxglove());
    let topics: Vec<&str> = app.topics.values().map(String::as_str).collect();
    assert_eq!(
        topics,
        ["/clock", "/tf_static", "/tf", "/odom", "/cmd_vel", "/scan", "/scan_points"]
    );
    app.subscribe(&["/scan"]);
    app.settle();
    assert!(live.control(&["step", "10"]));
    app.until(|received| received.topic == "/scan");
    assert!(live.control(&["stop"]));
    drop((app, viewed));
    live.ends_with(3);
}
