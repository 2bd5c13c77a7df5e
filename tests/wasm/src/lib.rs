//! The golden runs for WebAssembly: no imports, no glue, four functions.
//!
//! | export                      | meaning                                                        |
//! |-----------------------------|----------------------------------------------------------------|
//! | `memory`                    | the module's own memory                                        |
//! | `golden_count() -> u32`     | how many golden runs there are                                 |
//! | `golden_digest(i) -> u32`   | simulates run `i`; address of its digest, 32 ASCII hexadecimal digits; 0 if there is no such run |
//! | `golden_log(i) -> u32`      | records run `i`; address of its log, as a file would have it; 0 if there is no such run |
//! | `golden_log_length() -> u32` | length of the log that was recorded last, bytes               |
//!
//! That it links at all says as much as its digests do: a world that reads a
//! clock, a file or the system's random numbers would have to import them.

use std::sync::Mutex;

use rusty_sim::GOLDENS;

/// Length of a digest in memory, bytes.
const DIGITS: usize = 32;

/// Where the digest asked for last lies.
static FOUND: Mutex<[u8; DIGITS]> = Mutex::new([0; DIGITS]);

/// The log recorded last.
static LOG: Mutex<Vec<u8>> = Mutex::new(Vec::new());

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

/// Records golden run `index`, from 0. Returns the address of the bytes of its log,
/// which stay there until the next call; the null address where there is no such run.
#[unsafe(no_mangle)]
pub extern "C" fn golden_log(index: u32) -> *const u8 {
    let log = GOLDENS.get(index as usize).and_then(|one| one.record().ok());
    let bytes = log.and_then(|log| log.write(Vec::new()).ok());
    let (Some(bytes), Ok(mut place)) = (bytes, LOG.lock()) else { return std::ptr::null() };
    *place = bytes;
    place.as_ptr()
}

/// The length of the log that was recorded last, bytes.
#[unsafe(no_mangle)]
pub extern "C" fn golden_log_length() -> u32 {
    LOG.lock().map_or(0, |log| log.len() as u32)
}
