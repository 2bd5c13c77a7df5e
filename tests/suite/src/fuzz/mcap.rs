//! A recording of ROS 2 in an MCAP file, and the run log and trajectory made from it.

use std::collections::BTreeMap;
use std::io::{Cursor, Write as _};
use std::sync::atomic::AtomicBool;

use mcap::records::{MessageHeader, op};
use mcap::{MessageStream, WriteOptions};
use rusty_logs::export::mcap::{RosOptions as ExportOptions, export};
use rusty_logs::import::ImportOptions;
use rusty_logs::import::ros::{Poses, RosOptions, import_ros, import_trajectory};
use ruzstd::encoding::{CompressionLevel, compress_to_vec};

use super::imported::{check, place};

/// Words of the format.
pub const WORDS: [&str; 8] =
    ["lz4", "zstd", "cdr", "odom", "map", "base_link", "\u{5}", "\u{0}\u{0}\u{0}\u{0}\u{0}"];

/// Topics of the seeds.
const TOPICS: [&str; 6] =
    ["/scan", "/odom", "/tf", "/tf_static", "/truth/pose", "/dead_reckoning/pose"];
const MAGIC: &[u8] = b"\x89MCAP0\r\n";

/// Imports the recording and reads the run log, then takes poses from it in both ways.
pub fn mcap(bytes: &[u8]) -> bool {
    let [input, output, poses] = ["in.mcap", "out.log", "out.tum"].map(place);
    std::fs::write(&input, bytes).expect("a file can be written");
    for wanted in [
        Poses::Topic(None),
        Poses::Frames { parent: "map".to_owned(), child: "base_link".to_owned() },
    ] {
        if let Ok(report) = import_trajectory(&input, &poses, &wanted, &mut |_| ()) {
            let text = std::fs::read_to_string(&poses).expect("what was imported is there");
            assert_eq!(text.lines().count() as u64, report.poses);
            let mut numbers = text.split_ascii_whitespace().map(|word| word.parse::<f64>());
            assert!(numbers.all(|number| number.is_ok_and(f64::is_finite)));
        }
    }
    let mut lines = 0;
    let options = ImportOptions { writer: "fuzz", strict: false };
    let truth = Some("/truth/pose".to_owned());
    let with_truth = RosOptions { truth, ..RosOptions::default() };
    let done = [with_truth, RosOptions::default()].into_iter().find_map(|ros| {
        import_ros(&input, false, &output, &ros, options, &mut |done| lines = done).ok()
    });
    let Some(report) = done else { return false };
    check(&report, &output, lines);
    true
}

/// Recordings of a log that this target reads: without chunks, with chunks, and with
/// chunks that are packed. None has checksums, which mutants would fail.
pub fn seeds(log: &[u8]) -> Vec<(&'static str, Vec<u8>)> {
    let folder = tempfile::tempdir().expect("a folder");
    let [from, to] = ["run.log", "run.mcap"].map(|name| folder.path().join(name));
    std::fs::write(&from, log).expect("a file can be written");
    let options = ExportOptions { truth: true, ..ExportOptions::default() };
    export(&from, &to, &options, &AtomicBool::new(false)).expect("a log is exported");
    let bytes = std::fs::read(&to).expect("what was exported is there");
    let plain = again(&bytes, WriteOptions::new().use_chunks(false));
    let mut lz4 = lz4_flex::frame::FrameEncoder::new(Vec::new());
    lz4.write_all(&records(&plain)).expect("memory");
    let zstd = compress_to_vec(&*records(&plain), CompressionLevel::Fastest);
    vec![
        ("lz4", packed("lz4", &records(&plain), &lz4.finish().expect("memory"))),
        ("zstd", packed("zstd", &records(&plain), &zstd)),
        ("chunks", packed("", &records(&plain), &records(&plain))),
        ("plain", plain),
    ]
}

/// The messages of the topics in another file, without definitions of their types.
fn again(bytes: &[u8], options: WriteOptions) -> Vec<u8> {
    let options = options.calculate_chunk_crcs(false).calculate_data_section_crc(false);
    let mut file = Cursor::new(Vec::new());
    let mut writer = options.compression(None).create(&mut file).expect("memory");
    let mut ids = BTreeMap::new();
    for message in MessageStream::new(bytes).expect("a file of ours").map(Result::unwrap) {
        let topic = message.channel.topic.clone();
        if !TOPICS.contains(&&*topic) {
            continue;
        }
        let name = message.channel.schema.as_ref().map_or("", |schema| &schema.name);
        let channel_id = *ids.entry(topic).or_insert_with_key(|topic| {
            let schema = writer.add_schema(name, "ros2msg", &[]).expect("memory");
            writer.add_channel(schema, topic, "cdr", &BTreeMap::new()).expect("memory")
        });
        let (log_time, publish_time) = (message.log_time, message.publish_time);
        let header = MessageHeader { channel_id, sequence: 0, log_time, publish_time };
        writer.write_to_known_channel(&header, &message.data).expect("memory");
    }
    writer.finish().expect("memory");
    drop(writer);
    file.into_inner()
}

/// The schemas, channels and messages of a file without chunks.
fn records(bytes: &[u8]) -> Vec<u8> {
    let (mut found, mut rest) = (Vec::new(), &bytes[MAGIC.len()..]);
    while let [code, a, b, c, d, e, f, g, h, ..] = rest {
        let length = 9 + u64::from_le_bytes([*a, *b, *c, *d, *e, *f, *g, *h]) as usize;
        if *code == op::DATA_END {
            break;
        }
        if matches!(*code, op::SCHEMA | op::CHANNEL | op::MESSAGE) {
            found.extend(&rest[..length]);
        }
        rest = &rest[length..];
    }
    found
}

/// A file with one chunk, without a summary.
fn packed(how: &str, records: &[u8], packed: &[u8]) -> Vec<u8> {
    let record =
        |code: u8, body: &[u8]| [&[code][..], &(body.len() as u64).to_le_bytes(), body].concat();
    let times_and_size = [0, u64::MAX, records.len() as u64].map(u64::to_le_bytes).concat();
    let (no_crc, length) = ([0; 4], (how.len() as u32).to_le_bytes());
    let size = (packed.len() as u64).to_le_bytes();
    let chunk = [&*times_and_size, &no_crc, &length, how.as_bytes(), &size, packed].concat();
    let parts = [
        MAGIC.to_vec(),
        record(op::HEADER, &[0; 8]),
        record(op::CHUNK, &chunk),
        record(op::DATA_END, &[0; 4]),
        record(op::FOOTER, &[0; 20]),
        MAGIC.to_vec(),
    ];
    parts.concat()
}
