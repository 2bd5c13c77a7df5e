//! Messages as bytes and back: CDR as the DDS of ROS 2 writes it.
//!
//! Source: OMG, *DDS-XTypes 1.3*, section 7.4.1 (plain CDR, XCDR1), and OMG, *RTPS 2.5*,
//! section 10: four bytes ahead of the message name the encoding, alignment counts
//! from behind them.

use byteorder::{BigEndian, LittleEndian};
use serde::Serialize;
use serde::de::DeserializeOwned;
use thiserror::Error;

/// The four bytes ahead of a message: plain CDR, least byte first.
const HEAD: [u8; 4] = [0, 1, 0, 0];

/// Why bytes are not a message, or a message not bytes.
#[derive(Debug, Error)]
pub enum CdrError {
    /// The four bytes ahead name another encoding.
    #[error(
        "expected plain CDR (00 00 or 00 01 ahead of the message), got {0:02x?}; record with the \
         serialization format cdr"
    )]
    Encoding(Vec<u8>),
    /// The message does not fit its type.
    #[error("{0}; the message is damaged, or of another version of its type")]
    Content(#[from] cdr_encoding::Error),
}

/// A type of ROS.
pub trait RosMessage: Serialize + Sized {
    /// Package, `msg` and type: `sensor_msgs/msg/LaserScan`.
    const NAME: &'static str;

    /// Adds the bytes of this message to `out`.
    ///
    /// # Errors
    /// [`CdrError::Content`], of which no type here is capable.
    fn append_cdr(&self, out: &mut Vec<u8>) -> Result<(), CdrError> {
        out.extend(HEAD);
        cdr_encoding::to_writer::<_, LittleEndian, _>(out, self).map_err(CdrError::from)
    }

    /// Returns the bytes of this message.
    ///
    /// # Errors
    /// As [`append_cdr`](Self::append_cdr).
    fn to_cdr(&self) -> Result<Vec<u8>, CdrError> {
        let mut bytes = Vec::new();
        self.append_cdr(&mut bytes)?;
        Ok(bytes)
    }
}

/// Reads a message, of either byte order. Bytes behind it are fields of a later version
/// of its type, and ignored. Memory follows the length of `bytes`.
///
/// # Errors
/// [`CdrError`].
pub fn from_cdr<M: DeserializeOwned>(bytes: &[u8]) -> Result<M, CdrError> {
    let (message, _) = match bytes {
        [0, 0, _, _, body @ ..] => cdr_encoding::from_bytes::<M, BigEndian>(body)?,
        [0, 1, _, _, body @ ..] => cdr_encoding::from_bytes::<M, LittleEndian>(body)?,
        other => return Err(CdrError::Encoding(other[..other.len().min(4)].to_vec())),
    };
    Ok(message)
}
