//! `layout`: print the layout of the structs in shared memory.

use anyhow::Result;
use rusty_contract::belief::{self as beliefs, belief_hash};
use rusty_contract::layout::{layout_hash, tables};
use rusty_contract::{Exit, PROTOCOL_VERSION, outln};
use serde_json::json;

use super::arguments::Output;

pub fn run(output: &Output) -> Result<Exit> {
    let hash = format!("{:016x}", layout_hash());
    let document = json!({
        "protocol": PROTOCOL_VERSION,
        "layout_hash": hash,
        "structs": tables(),
        "belief_hash": format!("{:016x}", belief_hash()),
        "belief_structs": beliefs::tables(),
    });
    output.print_with(&document, || print(&hash));
    Ok(Exit::Done)
}

fn print(hash: &str) {
    outln!("protocol {PROTOCOL_VERSION}, layout {hash}, little-endian, alignment 8");
    outln!("(the last two, of beliefs, have a hash of their own: {:016x})", belief_hash());
    for table in tables().into_iter().chain(beliefs::tables()) {
        outln!("\n{} ({} bytes)", table.name, table.size);
        outln!("{:>8}  {:>6}  {:14}  type", "offset", "size", "field");
        for f in table.fields {
            outln!("{:>8}  {:>6}  {:14}  {}", f.offset, f.size, f.name, f.ty);
        }
    }
}
