//! `HeldFrame`: a frame for as long as it is held.

use std::ops::Deref;
use std::rc::Rc;

use rusty_contract::Frame;
#[cfg(feature = "link")]
use rusty_link::BorrowedFrame;

/// A frame in shared memory, or one read from a log.
pub(crate) enum FrameHandle {
    #[cfg(feature = "link")]
    Live(BorrowedFrame),
    Log(Rc<Frame>),
}

impl Deref for FrameHandle {
    type Target = Frame;

    fn deref(&self) -> &Frame {
        match self {
            #[cfg(feature = "link")]
            Self::Live(frame) => frame,
            Self::Log(frame) => frame,
        }
    }
}

/// A frame that borrows nothing: it lies where it is, unchanged, for as long as
/// it is held, even when the session or the server has ended. A session can hold
/// [`MAX_HELD_FRAMES`](rusty_link::MAX_HELD_FRAMES) of a run at a time, the one
/// it waits for included.
#[cfg(feature = "link")]
pub struct HeldFrame(pub(crate) FrameHandle);

#[cfg(feature = "link")]
impl Deref for HeldFrame {
    type Target = Frame;

    fn deref(&self) -> &Frame {
        &self.0
    }
}
