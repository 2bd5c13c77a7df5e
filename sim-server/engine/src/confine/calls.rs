//! The filter of system calls of a confined process.
//!
//! * A call in [`ALLOWED`] or [`ALLOWED_HERE`] is allowed, except with the
//!   arguments that [`refused`] names.
//! * A call in [`REFUSED`] fails with EPERM: a program that reports the error
//!   reports the reason.
//! * Any other call, also one that a later kernel adds, fails with ENOSYS, as
//!   in a kernel without it, so that libraries use the call that they used
//!   before. `clone3` is one: a filter cannot read its flags.
//!
//! Landlock decides which files are opened. The filter closes other ways:
//! memory of other processes, networks, calls that do the work of other calls,
//! and changes to files by name, which Landlock does not check.

use libc::c_long;
use seccompiler::{
    BpfProgram, SeccompAction, SeccompCmpArgLen, SeccompCmpOp, SeccompCondition, SeccompFilter,
    SeccompRule, TargetArch,
};

use super::allowed::{ALLOWED, ALLOWED_HERE};

/// Refused with EPERM for all arguments.
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
    libc::SYS_shmat,
    libc::SYS_shmctl,
    libc::SYS_msgget,
    libc::SYS_msgsnd,
    libc::SYS_msgrcv,
    libc::SYS_msgctl,
    libc::SYS_semget,
    libc::SYS_semop,
    libc::SYS_semtimedop,
    libc::SYS_semctl,
    libc::SYS_mq_open,
    libc::SYS_mq_unlink,
    // Programs without a path that Landlock could check.
    libc::SYS_execveat,
    libc::SYS_memfd_create,
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
    // Modes, owners and times by name; attributes by name or open file.
    libc::SYS_fchmodat,
    libc::SYS_fchmodat2,
    libc::SYS_fchownat,
    libc::SYS_utimensat,
    libc::SYS_setxattr,
    libc::SYS_lsetxattr,
    libc::SYS_fsetxattr,
    libc::SYS_removexattr,
    libc::SYS_lremovexattr,
    libc::SYS_fremovexattr,
    libc::SYS_getxattr,
    libc::SYS_lgetxattr,
    libc::SYS_listxattr,
    libc::SYS_llistxattr,
    // setxattrat, getxattrat, listxattrat, removexattrat, open_tree_attr,
    // file_getattr, file_setattr: newer than the constants of `libc`.
    463,
    464,
    465,
    466,
    467,
    468,
    469,
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

/// The only requests to open files (`ioctl`, argument 1): what standard input
/// and output are, and how files are read and closed. Others change attributes
/// of files, or list the networks of the machine.
const IOCTL: &[libc::Ioctl] = &[
    libc::TCGETS,
    0x802C_542A_u32 as libc::Ioctl, // TCGETS2
    libc::TIOCGWINSZ,
    libc::FIONREAD,
    libc::FIONBIO,
    libc::FIOCLEX,
    libc::FIONCLEX,
];

/// The only settings of a process (`prctl`, argument 0). Others give other
/// processes access to this one, or share processors with them.
const PRCTL: &[libc::c_int] = &[
    libc::PR_SET_NAME,
    libc::PR_GET_NAME,
    libc::PR_SET_PDEATHSIG,
    libc::PR_GET_PDEATHSIG,
    libc::PR_SET_DUMPABLE,
    libc::PR_GET_DUMPABLE,
    libc::PR_SET_NO_NEW_PRIVS,
    libc::PR_GET_NO_NEW_PRIVS,
    libc::PR_GET_SECCOMP,
    libc::PR_CAPBSET_READ,
    libc::PR_SET_TIMERSLACK,
    libc::PR_GET_TIMERSLACK,
    libc::PR_SET_THP_DISABLE,
    libc::PR_GET_THP_DISABLE,
    libc::PR_SET_VMA,
];

/// Makes a condition on argument `index`.
fn compare(
    index: u8,
    op: SeccompCmpOp,
    value: u64,
) -> Result<SeccompCondition, seccompiler::Error> {
    Ok(SeccompCondition::new(index, SeccompCmpArgLen::Dword, op, value)?)
}

/// A call is refused if argument `index` compares so.
fn when(index: u8, op: SeccompCmpOp, value: u64) -> Result<SeccompRule, seccompiler::Error> {
    Ok(SeccompRule::new(vec![compare(index, op, value)?])?)
}

/// A call is refused if argument `index` has none of these values.
fn unless(
    index: u8,
    values: impl IntoIterator<Item = u64>,
) -> Result<SeccompRule, seccompiler::Error> {
    let conditions = values.into_iter().map(|value| compare(index, SeccompCmpOp::Ne, value));
    Ok(SeccompRule::new(conditions.collect::<Result<_, _>>()?)?)
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
    let not_unix = || when(0, SeccompCmpOp::Ne, libc::AF_UNIX as u64);
    rules.insert(
        libc::SYS_socket,
        vec![not_unix()?, of_type(libc::SOCK_STREAM)?, of_type(libc::SOCK_SEQPACKET)?],
    );
    rules.insert(libc::SYS_socketpair, vec![not_unix()?]);
    // Children are the participant's own, not siblings of it.
    let flag = |flag| when(0, SeccompCmpOp::MaskedEq(flag as u64), flag as u64);
    rules.insert(libc::SYS_clone, vec![flag(libc::CLONE_NEWUSER)?, flag(libc::CLONE_PARENT)?]);
    let requests = IOCTL.iter().map(|&request| u64::from(request as u32));
    rules.insert(libc::SYS_ioctl, vec![unless(1, requests)?]);
    rules.insert(libc::SYS_prctl, vec![unless(0, PRCTL.iter().map(|&option| option as u64))?]);
    // Watching a folder, and a lease that delays who opens a file to write.
    let command = |command| when(1, SeccompCmpOp::Eq, command as u64);
    rules.insert(libc::SYS_fcntl, vec![command(libc::F_NOTIFY)?, command(libc::F_SETLEASE)?]);
    let arch = TargetArch::try_from(std::env::consts::ARCH)?;
    let eperm = SeccompAction::Errno(libc::EPERM as u32);
    Ok(SeccompFilter::new(rules, SeccompAction::Allow, eperm, arch)?.try_into()?)
}

/// The calls that no list names: they fail with ENOSYS.
fn unknown() -> Result<BpfProgram, seccompiler::Error> {
    let named = [ALLOWED, ALLOWED_HERE, REFUSED, REFUSED_OLD].concat();
    let rules = named.into_iter().map(|call| (call, Vec::new())).collect();
    let arch = TargetArch::try_from(std::env::consts::ARCH)?;
    let enosys = SeccompAction::Errno(libc::ENOSYS as u32);
    Ok(SeccompFilter::new(rules, enosys, SeccompAction::Allow, arch)?.try_into()?)
}

/// Applies both filters to this thread and all that it starts. The second
/// refuses the calls that apply a filter, so it comes last.
pub(super) fn refuse() -> Result<(), seccompiler::Error> {
    seccompiler::apply_filter(&refused()?)?;
    seccompiler::apply_filter(&unknown()?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rustix::process::{Resource, getrlimit};

    /// Calls by number, with arguments that no call accepts.
    fn call(number: c_long) -> Option<i32> {
        // SAFETY: no argument is an address or a descriptor that this process
        // has, and the callers pass numbers that the filter refuses.
        let result = unsafe { libc::syscall(number, -1, -1, -1, -1, -1, -1) };
        (result < 0).then(|| std::io::Error::last_os_error().raw_os_error()).flatten()
    }

    #[test]
    fn a_call_is_allowed_or_refused_and_any_other_is_not_there() {
        if !can_be_filtered() {
            println!("skipped: no seccomp filter for this processor");
            return;
        }
        let allowed = [ALLOWED, ALLOWED_HERE].concat();
        let refused = [REFUSED, REFUSED_OLD].concat();
        std::thread::spawn(move || {
            refuse().unwrap();
            for number in &refused {
                assert!(!allowed.contains(number), "call {number} is in both lists");
                assert_eq!(call(*number), Some(libc::EPERM), "call {number}");
            }
            // The numbers of x32 do the same work from 0x4000_0000 on. No filter
            // sees `uretprobe` and `uprobe`, which end the caller unless root
            // has set a probe.
            let probes = if cfg!(target_arch = "x86_64") { 335..337 } else { 0..0 };
            let numbers = (0..1024).filter(|n| !probes.contains(n));
            let numbers = numbers.flat_map(|n| [n, n | 0x4000_0000]);
            for number in numbers.filter(|n| !allowed.contains(n) && !refused.contains(n)) {
                assert_eq!(call(number), Some(libc::ENOSYS), "call {number}");
            }
            // Allowed for itself, with its own arguments.
            assert_ne!(getrlimit(Resource::Nofile).current, Some(0));
            assert!(std::thread::spawn(|| ()).join().is_ok());
            assert!(std::os::unix::net::UnixStream::pair().is_ok());
        })
        .join()
        .unwrap();
    }

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
