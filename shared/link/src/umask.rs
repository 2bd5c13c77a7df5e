//! Keeps the umask of the process while the transport changes it.
//!
//! iceoryx2 0.10 sets the umask to 0177 while it binds a socket
//! (`iceoryx2-bb-posix/src/unix_datagram_socket.rs`). The umask belongs to the process: of
//! two threads that do so at a time, the second restores 0177, and from then on new folders
//! cannot be entered. What another thread makes meanwhile has the same mode. So whatever
//! opens a socket, makes a folder or starts a process does it here, one at a time.

use std::sync::{Mutex, PoisonError};

static UMASK: Mutex<()> = Mutex::new(());

/// Does `make` while no other thread opens a port of the transport.
pub fn with_umask<T>(make: impl FnOnce() -> T) -> T {
    let _kept = UMASK.lock().unwrap_or_else(PoisonError::into_inner);
    make()
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::MetadataExt as _;

    use rusty_contract::{RunName, TruthKey};

    use crate::{Domain, ServerLink, WaitPolicy};

    fn umask() -> String {
        let status = std::fs::read_to_string("/proc/self/status").unwrap();
        let line = status.lines().find(|line| line.starts_with("Umask:"));
        line.unwrap().to_owned()
    }

    #[test]
    fn threads_that_serve_runs_at_a_time_keep_the_umask_and_enter_their_folders() {
        let before = umask();
        let serve = |thread: usize| {
            for number in 0..12 {
                let name = format!("t{}-umask-{thread}-{number}", std::process::id());
                let domain = Domain::create(&RunName::new(&name).unwrap()).unwrap();
                for folder in [domain.folder().to_owned(), domain.memory()] {
                    assert_eq!(folder.metadata().unwrap().mode() & 0o777, 0o700, "{name}");
                }
                let key = TruthKey::from_bytes([7; 32]);
                drop(ServerLink::create(&domain, WaitPolicy::Block, &key).unwrap());
            }
        };
        std::thread::scope(|scope| {
            (0..8).for_each(|thread| drop(scope.spawn(move || serve(thread))));
        });
        assert_eq!(umask(), before);
    }
}
