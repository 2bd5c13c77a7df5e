//! The transport's building blocks: as in [`iceoryx2::service::ipc`], but with
//! all memory in files of the run's folder.
//!
//! `ipc` keeps its memory in `/dev/shm`, one flat folder that all programs of
//! all users share. There, a process that may open one segment may open all, and
//! may make files that outlive it. Files in a folder have the permissions of the
//! folder, and a sandbox rules over them by folder. The run's folder is in
//! `/dev/shm` too, so the pages are the same and so is the cost of a tick.

use std::fmt::Debug;

use iceoryx2::prelude::ZeroCopySend;
use iceoryx2::service::Service;
use iceoryx2::service::internal::ServiceInternal;
use iceoryx2::service::ipc;
use iceoryx2_bb_elementary_traits::testing::abandonable::Abandonable;
use iceoryx2_cal::dynamic_storage::file::Storage;
use iceoryx2_cal::event::event_state::counting_bit_set::RelocatableCountingBitSet;
use iceoryx2_cal::event::trigger::State;
use iceoryx2_cal::event::trigger::unix_datagram_socket::GenericUnixDatagramSocketTrigger;
use iceoryx2_cal::resizable_shared_memory::dynamic::DynamicMemory;
use iceoryx2_cal::shared_memory::file::Memory;
use iceoryx2_cal::shm_allocator::bump_allocator::BumpAllocator;
use iceoryx2_cal::shm_allocator::pool_allocator::PoolAllocator;
use iceoryx2_cal::zero_copy_connection::file::Connection;

/// A transport whose memory is in files of a folder.
#[derive(Clone, Debug)]
pub struct Wire;

type Ipc = ipc::Service;
type EventState = State<RelocatableCountingBitSet, ()>;

impl Service for Wire {
    type StaticStorage = <Ipc as Service>::StaticStorage;
    type ConfigSerializer = <Ipc as Service>::ConfigSerializer;
    type PersistentDynamicStorage<T: Debug + Send + Sync + ZeroCopySend + 'static> = Storage<T>;
    type Bag = <Ipc as Service>::Bag;
    type DynamicStorage<T: Debug + Send + Sync + ZeroCopySend + 'static> = Storage<T>;
    type ServiceNameHasher = <Ipc as Service>::ServiceNameHasher;
    type SharedMemory = Memory<PoolAllocator>;
    type ResizableSharedMemory = DynamicMemory<PoolAllocator, Memory<PoolAllocator>>;
    type Connection = Connection;
    type Event = GenericUnixDatagramSocketTrigger<RelocatableCountingBitSet, Storage<EventState>>;
    type Monitoring = <Ipc as Service>::Monitoring;
    type Reactor = <Ipc as Service>::Reactor;
    type ArcThreadSafetyPolicy<T: Send + Debug + Abandonable> =
        <Ipc as Service>::ArcThreadSafetyPolicy<T>;
    type BlackboardMgmt<K: Send + Sync + Debug + ZeroCopySend + 'static> = Storage<K>;
    type BlackboardPayload = Memory<BumpAllocator>;
    type UniqueId = <Ipc as Service>::UniqueId;
}

impl ServiceInternal<Wire> for Wire {}
