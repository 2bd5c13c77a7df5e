//! How much memory a piece of work takes: an allocator that counts.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

/// What a thread has allocated.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Allocated {
    pub times: i64,
    /// Longest allocation since this was last looked at, bytes.
    pub longest: usize,
    /// Bytes in use.
    pub held: i64,
    /// The most of them.
    most: i64,
}

thread_local! {
    static ALLOCATED: Cell<Allocated> =
        const { Cell::new(Allocated { times: 0, longest: 0, held: 0, most: 0 }) };
}

/// The system's allocator, counting what each thread has in use. A test
/// program makes it its `#[global_allocator]`; without it [`measured`] says 0.
pub struct Counting;

/// Counts bytes that are taken, and then bytes that are given back.
fn count(taken: usize, given: usize) {
    // A thread that is ending has no counters any more.
    let _ = ALLOCATED.try_with(|cell| {
        let Allocated { times, longest, held, most } = cell.get();
        let (times, longest) = (times + i64::from(taken > 0), longest.max(taken));
        let held = held + taken as i64;
        cell.set(Allocated { times, longest, held: held - given as i64, most: most.max(held) });
    });
}

// SAFETY: every call goes to the system's allocator as it came; counting
// neither allocates nor panics.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(layout.size(), 0);
        // SAFETY: as the caller promises.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        count(layout.size(), 0);
        // SAFETY: as the caller promises.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        count(0, layout.size());
        // SAFETY: as the caller promises.
        unsafe { System.dealloc(place, layout) }
    }

    unsafe fn realloc(&self, place: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // Both are in memory while the bytes move.
        count(size, layout.size());
        // SAFETY: as the caller promises.
        unsafe { System.realloc(place, layout, size) }
    }
}

/// What this thread allocated so far; the longest is that since the last call.
pub fn allocated() -> Allocated {
    ALLOCATED.with(|cell| cell.replace(Allocated { longest: 0, ..cell.get() }))
}

/// Does `work` and says how many bytes of memory this thread had in use for it
/// at once.
pub fn measured<T>(work: impl FnOnce() -> T) -> (T, usize) {
    let before = allocated();
    ALLOCATED.set(Allocated { most: before.held, ..before });
    let done = work();
    (done, (allocated().most - before.held) as usize)
}
