//! What a port of the transport tells of its other end, and replies to it.

use iceoryx2::active_request::ActiveRequest;
use iceoryx2::service::Service;
use iceoryx2::unique_id_generator::{UniqueId, UniqueIdGenerator};

use crate::LinkError;
use crate::services::Ipc;

/// The process that made the port with this number, as the transport has it;
/// 0 if it does not say.
pub(crate) fn process_of(port: u128) -> u32 {
    // SAFETY: the number is that of a port, which the transport itself drew.
    let id = unsafe { UniqueId::from_raw_id(port) };
    let pid = <<Ipc as Service>::UniqueId as UniqueIdGenerator>::pid(id);
    pid.ok().and_then(|pid| u32::try_from(pid.value()).ok()).unwrap_or(0)
}

/// Sends a reply; fails for instance because the caller has ended.
pub(crate) fn respond(
    active: &ActiveRequest<Ipc, [u8], (), [u8], ()>,
    json: &[u8],
) -> Result<(), LinkError> {
    let loan =
        active.loan_slice_uninit(json.len()).map_err(LinkError::transport("loan a reply"))?;
    let response = loan.write_from_slice(json);
    response.send().map(|_| ()).map_err(LinkError::transport("send a reply"))
}
