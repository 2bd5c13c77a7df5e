//! `layout`: the structs in shared memory, byte by byte.

use rusty_contract::belief::{self as beliefs, belief_hash};
use rusty_contract::layout::{layout_hash, tables};
use rusty_contract::{Exit, PROTOCOL_VERSION, outln};
use serde_json::json;

use super::{Verbed, print_json};
use crate::cli::JsonArgs;

/// Prints the layout, as a table or JSON.
///
/// # Errors
/// None.
pub fn layout(args: &JsonArgs) -> Verbed {
    let hash = format!("{:016x}", layout_hash());
    if args.json {
        print_json(&json!({
            "protocol": PROTOCOL_VERSION,
            "layout_hash": hash,
            "structs": tables(),
            "belief_hash": format!("{:016x}", belief_hash()),
            "belief_structs": beliefs::tables(),
        }));
        return Ok(Exit::Done);
    }
    outln!("protocol {PROTOCOL_VERSION}, layout {hash}, little-endian, alignment 8");
    outln!("(the last two, of beliefs, have a hash of their own: {:016x})", belief_hash());
    for table in tables().into_iter().chain(beliefs::tables()) {
        outln!("\n{} ({} bytes)", table.name, table.size);
        outln!("{:>8}  {:>6}  {:14}  type", "offset", "size", "field");
        for f in table.fields {
            outln!("{:>8}  {:>6}  {:14}  {}", f.offset, f.size, f.name, f.ty);
        }
    }
    Ok(Exit::Done)
}
