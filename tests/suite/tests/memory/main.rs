//! A tick takes no memory.

mod allocations;
mod steady_memory;

use rusty_tests::fuzz::memory::Counting;

#[global_allocator]
static ALLOCATOR: Counting = Counting;
