//! The same bits: what repeats a run to the bit, what must not change one, and what must.

mod control;
mod fork;
mod must_not_matter;
mod overlap;
mod recorded;
mod robots;
mod same_bits;
mod seeds;
mod sensed;
mod timing;
mod verify_clients;
mod wasm;
