//! System calls with arguments that do nothing: the error shows whether the
//! kernel let the caller in.

use std::io;

use libc::{self as c, c_long};

use super::report;

/// No address, no descriptor, no flags that a call knows.
const BAD: c_long = -1;

/// Makes every call, each an attempt. One that is let in succeeds, or fails for
/// its arguments.
#[rustfmt::skip]
pub(super) fn try_calls(server: u32) {
    let (server, me) = (c_long::from(server), c_long::from(std::process::id()));
    let (unix, local) = (c_long::from(c::AF_UNIX), c_long::from(c::AF_NETLINK));
    let new_user = c_long::from(c::CLONE_NEWUSER | c::CLONE_FS);
    let sibling = c_long::from(c::CLONE_PARENT | c::CLONE_THREAD);
    let calls: &[(&str, c_long, &[c_long])] = &[
        // Attributes, owners and times by name.
        ("setxattr", c::SYS_setxattr, &[]), ("fsetxattr", c::SYS_fsetxattr, &[]),
        ("removexattr", c::SYS_removexattr, &[]), ("getxattr", c::SYS_getxattr, &[]),
        ("setxattrat", 463, &[]), ("getxattrat", 464, &[]), ("listxattrat", 465, &[]),
        ("removexattrat", 466, &[]), ("file_getattr", 468, &[]), ("file_setattr", 469, &[]),
        ("fchownat", c::SYS_fchownat, &[]), ("utimensat", c::SYS_utimensat, &[]),
        ("ioctl-setflags", c::SYS_ioctl, &[BAD, 0x4008_6602]),
        // Other views of the file system.
        ("mount", c::SYS_mount, &[]), ("open_tree", c::SYS_open_tree, &[]),
        ("open_tree_attr", 467, &[]), ("name_to_handle_at", c::SYS_name_to_handle_at, &[]),
        ("chroot", c::SYS_chroot, &[]), ("unshare", c::SYS_unshare, &[]),
        ("setns", c::SYS_setns, &[]), ("clone-new-user", c::SYS_clone, &[new_user]),
        ("dnotify", c::SYS_fcntl, &[BAD, c::F_NOTIFY as c_long]),
        ("lease", c::SYS_fcntl, &[BAD, c::F_SETLEASE as c_long]),
        // Memory, queues and semaphores without files.
        ("shmget", c::SYS_shmget, &[0x5255, 4096, 0]), ("shmat", c::SYS_shmat, &[]),
        ("shmctl", c::SYS_shmctl, &[]), ("msgget", c::SYS_msgget, &[0x5255, 0]),
        ("msgsnd", c::SYS_msgsnd, &[]), ("msgrcv", c::SYS_msgrcv, &[]),
        ("msgctl", c::SYS_msgctl, &[]), ("semget", c::SYS_semget, &[0x5255, 1, 0]),
        ("semop", c::SYS_semop, &[]), ("semctl", c::SYS_semctl, &[]),
        ("mq_open", c::SYS_mq_open, &[]), ("mq_unlink", c::SYS_mq_unlink, &[]),
        // Programs without a path.
        ("execveat", c::SYS_execveat, &[]), ("memfd_create", c::SYS_memfd_create, &[BAD, 0]),
        // Other processes.
        ("kcmp", c::SYS_kcmp, &[me, me, 99]),
        ("pidfd_getfd", c::SYS_pidfd_getfd, &[]), ("move_pages", c::SYS_move_pages, &[]),
        ("process_madvise", c::SYS_process_madvise, &[]),
        ("limits-of-server", c::SYS_prlimit64, &[server, c::RLIMIT_NOFILE as c_long, 0, 0]),
        ("scheduler-of-server", c::SYS_sched_setscheduler, &[server]),
        ("setpriority", c::SYS_setpriority, &[]), ("setpgid", c::SYS_setpgid, &[]),
        ("clone-sibling", c::SYS_clone, &[sibling]),
        ("allow-tracer", c::SYS_prctl, &[c::PR_SET_PTRACER as c_long, server]),
        // Sockets of other kinds.
        ("netlink", c::SYS_socket, &[local, c::SOCK_RAW as c_long, 0]),
        ("seqpacket", c::SYS_socket, &[unix, c::SOCK_SEQPACKET as c_long, 0]),
        ("interfaces", c::SYS_ioctl, &[BAD, c::SIOCGIFCONF as c_long]),
        // Kernel interfaces that do other calls' work, or need no root to try.
        ("io_uring_setup", c::SYS_io_uring_setup, &[]), ("bpf", c::SYS_bpf, &[]),
        ("perf_event_open", c::SYS_perf_event_open, &[]), ("keyctl", c::SYS_keyctl, &[]),
        ("userfaultfd", c::SYS_userfaultfd, &[]), ("io_setup", c::SYS_io_setup, &[]),
        // On no list of the gate.
        ("quotactl", c::SYS_quotactl, &[]), ("statmount", 457, &[]),
        ("landlock", 444, &[0, 0, 1]), ("clone3", c::SYS_clone3, &[]),
    ];
    for (name, number, given) in calls {
        let mut words = [BAD; 6];
        words[..given.len()].copy_from_slice(given);
        let [a, b, c, d, e, f] = words;
        // SAFETY: an address among the arguments is -1 or 0, which the kernel
        // checks; none is of this process's memory.
        let result = unsafe { libc::syscall(*number, a, b, c, d, e, f) };
        let error = io::Error::last_os_error();
        let refused = matches!(error.raw_os_error(), Some(c::EPERM | c::ENOSYS));
        let how = if result < 0 && refused { Err(error) } else { Ok(format!("let in: {result}")) };
        report(&format!("call-{name}"), how);
    }
}
