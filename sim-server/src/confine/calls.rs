//! The system calls that a confined process is refused.
//!
//! A list of what is refused, not of what is allowed: an estimator may be any
//! program in any language. What files it opens is Landlock's part; this part
//! closes the ways around files: other processes' memory, networks, kernel
//! interfaces that open more than they say, changes to files by their names
//! alone, which Landlock does not see.

use libc::c_long;
use seccompiler::{
    BpfProgram, SeccompAction, SeccompCmpArgLen, SeccompCmpOp, SeccompCondition, SeccompFilter,
    SeccompRule, TargetArch, sock_filter,
};

/// Refused whatever the arguments, with EPERM.
const REFUSED: &[c_long] = &[
    // Other processes: their memory, descriptors, and where their pages lie.
    libc::SYS_ptrace,
    libc::SYS_process_vm_readv,
    libc::SYS_process_vm_writev,
    libc::SYS_process_madvise,
    libc::SYS_kcmp,
    libc::SYS_pidfd_getfd,
    libc::SYS_move_pages,
    libc::SYS_migrate_pages,
    libc::SYS_setpriority,
    libc::SYS_ioprio_set,
    // Interfaces that do other calls' work, or watch others do it.
    libc::SYS_io_uring_setup,
    libc::SYS_io_uring_enter,
    libc::SYS_io_uring_register,
    libc::SYS_bpf,
    libc::SYS_perf_event_open,
    libc::SYS_userfaultfd,
    libc::SYS_inotify_init1,
    libc::SYS_fanotify_init,
    libc::SYS_keyctl,
    libc::SYS_add_key,
    libc::SYS_request_key,
    // Memory and queues of System V, and of POSIX, have no files to rule over.
    libc::SYS_shmget,
    libc::SYS_msgget,
    libc::SYS_semget,
    libc::SYS_mq_open,
    // Leaving the group by which the server knows and ends it.
    libc::SYS_setpgid,
    libc::SYS_setsid,
    // Another view of the file system.
    libc::SYS_mount,
    libc::SYS_umount2,
    libc::SYS_pivot_root,
    libc::SYS_chroot,
    libc::SYS_move_mount,
    libc::SYS_open_tree,
    libc::SYS_fsopen,
    libc::SYS_fsconfig,
    libc::SYS_fsmount,
    libc::SYS_fspick,
    libc::SYS_mount_setattr,
    libc::SYS_unshare,
    libc::SYS_setns,
    libc::SYS_name_to_handle_at,
    libc::SYS_open_by_handle_at,
    // Modes, owners, times and attributes by name.
    libc::SYS_fchmodat,
    libc::SYS_fchmodat2,
    libc::SYS_fchownat,
    libc::SYS_utimensat,
    libc::SYS_setxattr,
    libc::SYS_lsetxattr,
    libc::SYS_removexattr,
    libc::SYS_lremovexattr,
];

/// The older forms of those, which this processor's kernel still has.
#[cfg(target_arch = "x86_64")]
const REFUSED_OLD: &[c_long] = &[
    libc::SYS_inotify_init,
    libc::SYS_chmod,
    libc::SYS_chown,
    libc::SYS_lchown,
    libc::SYS_utime,
    libc::SYS_utimes,
    libc::SYS_futimesat,
];
#[cfg(not(target_arch = "x86_64"))]
const REFUSED_OLD: &[c_long] = &[];

/// Refused for any process but the caller itself (argument 0 is not 0).
const OF_OTHERS: &[c_long] = &[
    libc::SYS_prlimit64,
    libc::SYS_sched_setaffinity,
    libc::SYS_sched_setattr,
    libc::SYS_sched_setparam,
    libc::SYS_sched_setscheduler,
];

/// From here on numbers are those of the x32 calls: the same work under other
/// numbers. (`x86/entry/syscalls/syscall_64.tbl` of the kernel.)
const FIRST_X32: u32 = 0x4000_0000;

/// A call is refused if argument `index` compares so.
fn when(index: u8, op: SeccompCmpOp, value: u64) -> Result<SeccompRule, seccompiler::Error> {
    let condition = SeccompCondition::new(index, SeccompCmpArgLen::Dword, op, value)?;
    Ok(SeccompRule::new(vec![condition])?)
}

/// Whether there is a filter for this processor.
pub(super) fn can_be_filtered() -> bool {
    TargetArch::try_from(std::env::consts::ARCH).is_ok()
}

/// The calls that are refused with EPERM; by any other processor's numbers
/// they end the process.
fn refused() -> Result<BpfProgram, seccompiler::Error> {
    const TYPE: u64 = 0xF;
    let mut rules = std::collections::BTreeMap::new();
    for call in REFUSED.iter().chain(REFUSED_OLD) {
        rules.insert(*call, Vec::new());
    }
    for call in OF_OTHERS {
        rules.insert(*call, vec![when(0, SeccompCmpOp::Ne, 0)?]);
    }
    // The transport wakes by datagrams between sockets in the run's folder.
    // Services of the machine listen on stream sockets.
    let of_type = |kind| when(1, SeccompCmpOp::MaskedEq(TYPE), kind as u64);
    rules.insert(
        libc::SYS_socket,
        vec![
            when(0, SeccompCmpOp::Ne, libc::AF_UNIX as u64)?,
            of_type(libc::SOCK_STREAM)?,
            of_type(libc::SOCK_SEQPACKET)?,
        ],
    );
    let new_user = libc::CLONE_NEWUSER as u64;
    rules.insert(libc::SYS_clone, vec![when(0, SeccompCmpOp::MaskedEq(new_user), new_user)?]);
    let arch = TargetArch::try_from(std::env::consts::ARCH)?;
    let eperm = SeccompAction::Errno(libc::EPERM as u32);
    Ok(SeccompFilter::new(rules, SeccompAction::Allow, eperm, arch)?.try_into()?)
}

/// Calls this kernel seems not to have (ENOSYS): `clone3`, whose flags no
/// filter can read, so that programs fall back to `clone`; and all of x32.
fn not_there() -> BpfProgram {
    let step = |code: u32, k: u32, jt, jf| sock_filter { code: code as u16, jt, jf, k };
    let answer = |k| step(libc::BPF_RET | libc::BPF_K, k, 0, 0);
    vec![
        // The call's number is the first field of what a filter sees.
        step(libc::BPF_LD | libc::BPF_W | libc::BPF_ABS, 0, 0, 0),
        step(libc::BPF_JMP | libc::BPF_JEQ | libc::BPF_K, libc::SYS_clone3 as u32, 1, 0),
        step(libc::BPF_JMP | libc::BPF_JGE | libc::BPF_K, FIRST_X32, 0, 1),
        answer(libc::SECCOMP_RET_ERRNO | libc::ENOSYS as u32),
        answer(libc::SECCOMP_RET_ALLOW),
    ]
}

/// Refuses them to this thread and all that comes of it.
pub(super) fn refuse() -> Result<(), seccompiler::Error> {
    seccompiler::apply_filter(&not_there())?;
    seccompiler::apply_filter(&refused()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thread_that_refuses_is_refused_and_no_other() {
        if !can_be_filtered() {
            println!("skipped: no seccomp filter for this processor");
            return;
        }
        let inotify = || rustix::fs::inotify::init(rustix::fs::inotify::CreateFlags::empty());
        let refused = std::thread::spawn(move || {
            assert!(inotify().is_ok());
            refuse().unwrap();
            let udp = std::net::UdpSocket::bind("127.0.0.1:0").unwrap_err();
            assert_eq!(udp.raw_os_error(), Some(libc::EPERM));
            assert!(std::os::unix::net::UnixDatagram::unbound().is_ok());
            inotify().unwrap_err()
        });
        assert_eq!(refused.join().unwrap(), rustix::io::Errno::PERM);
        assert!(inotify().is_ok());
        assert!(std::net::UdpSocket::bind("127.0.0.1:0").is_ok());
    }
}
