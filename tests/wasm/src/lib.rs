//! The golden runs for WebAssembly: no imports, no glue, two functions.
//!
//! | export                      | meaning                                                        |
//! |-----------------------------|----------------------------------------------------------------|
//! | `memory`                    | the module's own memory                                        |
//! | `golden_count() -> u32`     | how many golden runs there are                                 |
//! | `golden_digest(i) -> u32`   | simulates run `i`; address of its digest, 32 ASCII hexadecimal digits; 0 if there is no such run |
//!
//! That it links at all says as much as its digests do: a world that reads a
//! clock, a file or the system's random numbers would have to import them.

use std::sync::Mutex;

use rusty_sim::GOLDENS;

/// Length of a digest in memory, bytes.
const DIGITS: usize = 32;

/// Where the digest asked for last lies.
static FOUND: Mutex<[u8; DIGITS]> = Mutex::new([0; DIGITS]);

/// How many golden runs there are.
#[unsafe(no_mangle)]
pub extern "C" fn golden_count() -> u32 {
    GOLDENS.len() as u32
}

/// Simulates golden run `index`, from 0. Returns the address of its world
/// digest, 32 hexadecimal digits in ASCII, which stay there until the next
/// call; the null address where there is no such run.
#[unsafe(no_mangle)]
pub extern "C" fn golden_digest(index: u32) -> *const u8 {
    let found = GOLDENS.get(index as usize).and_then(|golden| golden.found().ok());
    let (Some(found), Ok(mut place)) = (found, FOUND.lock()) else { return std::ptr::null() };
    for (digit, byte) in place.iter_mut().zip(found.bytes()) {
        *digit = byte;
    }
    place.as_ptr()
}
