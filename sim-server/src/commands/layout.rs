//! `layout`: print the layout of the structs in shared memory.

use anyhow::Result;
use rusty_contract::belief::{self as beliefs, belief_hash};
use rusty_contract::layout::{layout_hash, tables};
use rusty_contract::{Exit, PROTOCOL_VERSION, TextTable, outln};
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
        let mut text = TextTable::new(">offset  >size  field  type");
        table.fields.iter().for_each(|f| text.row(&[&f.offset, &f.size, &f.name, &f.ty]));
        outln!("\n{} ({} bytes)\n{text}", table.name, table.size);
    }
}
