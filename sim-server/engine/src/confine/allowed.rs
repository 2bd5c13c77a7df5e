//! The system calls that a confined process may make: those that the C library
//! and the runtimes of Rust, C++, Python, Java and Go compute, wait, start
//! threads and children and read and write files with. Landlock decides which
//! files; `calls` refuses some of these calls by their arguments.

use libc::{self as c, c_long};

/// The calls that every processor has.
#[rustfmt::skip]
pub(super) const ALLOWED: &[c_long] = &[
    // Open files.
    c::SYS_read, c::SYS_write, c::SYS_readv, c::SYS_writev, c::SYS_pread64, c::SYS_pwrite64,
    c::SYS_preadv, c::SYS_pwritev, c::SYS_preadv2, c::SYS_pwritev2, c::SYS_lseek,
    c::SYS_close, c::SYS_close_range, c::SYS_dup, c::SYS_dup3, c::SYS_pipe2, c::SYS_fcntl,
    c::SYS_flock, c::SYS_ioctl, c::SYS_fstat, c::SYS_fstatfs, c::SYS_fchmod, c::SYS_fchown,
    c::SYS_ftruncate, c::SYS_fallocate, c::SYS_fadvise64, c::SYS_readahead, c::SYS_fsync,
    c::SYS_fdatasync, c::SYS_syncfs, c::SYS_sendfile, c::SYS_copy_file_range, c::SYS_splice,
    c::SYS_tee, c::SYS_vmsplice,
    // Files by name.
    c::SYS_openat, c::SYS_openat2, c::SYS_newfstatat, c::SYS_statx, c::SYS_statfs,
    c::SYS_readlinkat, c::SYS_faccessat, c::SYS_faccessat2, c::SYS_getdents64, c::SYS_getcwd,
    c::SYS_chdir, c::SYS_fchdir, c::SYS_truncate, c::SYS_umask, c::SYS_mkdirat, c::SYS_mknodat,
    c::SYS_unlinkat, c::SYS_renameat2, c::SYS_linkat, c::SYS_symlinkat, c::SYS_sync,
    // Waiting.
    c::SYS_ppoll, c::SYS_pselect6, c::SYS_epoll_create1, c::SYS_epoll_ctl, c::SYS_epoll_pwait,
    c::SYS_epoll_pwait2, c::SYS_eventfd2, c::SYS_signalfd4, c::SYS_timerfd_create,
    c::SYS_timerfd_settime, c::SYS_timerfd_gettime, c::SYS_futex, c::SYS_futex_waitv,
    c::SYS_nanosleep, c::SYS_clock_nanosleep, c::SYS_restart_syscall,
    // Memory.
    c::SYS_brk, c::SYS_mmap, c::SYS_munmap, c::SYS_mprotect, c::SYS_mremap, c::SYS_madvise,
    c::SYS_msync, c::SYS_mincore, c::SYS_mlock, c::SYS_mlock2, c::SYS_munlock, c::SYS_mlockall,
    c::SYS_munlockall, c::SYS_mbind, c::SYS_get_mempolicy, c::SYS_set_mempolicy,
    c::SYS_membarrier, c::SYS_pkey_alloc, c::SYS_pkey_free, c::SYS_pkey_mprotect,
    // Threads and children.
    c::SYS_clone, c::SYS_execve, c::SYS_exit, c::SYS_exit_group, c::SYS_wait4, c::SYS_waitid,
    c::SYS_set_robust_list, c::SYS_get_robust_list, c::SYS_set_tid_address, c::SYS_rseq,
    c::SYS_prctl, c::SYS_prlimit64, c::SYS_getrusage,
    // Watching the server: whether it has ended. (Its descriptors are refused.)
    c::SYS_pidfd_open,
    // Signals; Landlock keeps them among what the participant started.
    c::SYS_rt_sigaction, c::SYS_rt_sigprocmask, c::SYS_rt_sigpending, c::SYS_rt_sigtimedwait,
    c::SYS_rt_sigsuspend, c::SYS_rt_sigreturn, c::SYS_rt_sigqueueinfo, c::SYS_rt_tgsigqueueinfo,
    c::SYS_sigaltstack, c::SYS_kill, c::SYS_tkill, c::SYS_tgkill,
    // Clocks and timers.
    c::SYS_clock_gettime, c::SYS_clock_getres, c::SYS_gettimeofday, c::SYS_times,
    c::SYS_getitimer, c::SYS_setitimer, c::SYS_timer_create, c::SYS_timer_settime,
    c::SYS_timer_gettime, c::SYS_timer_getoverrun, c::SYS_timer_delete,
    // Processors.
    c::SYS_sched_yield, c::SYS_sched_getaffinity, c::SYS_sched_setaffinity,
    c::SYS_sched_getparam, c::SYS_sched_setparam, c::SYS_sched_getscheduler,
    c::SYS_sched_setscheduler, c::SYS_sched_getattr, c::SYS_sched_setattr,
    c::SYS_sched_get_priority_max, c::SYS_sched_get_priority_min, c::SYS_sched_rr_get_interval,
    c::SYS_getpriority, c::SYS_getcpu,
    // The process and the machine.
    c::SYS_getpid, c::SYS_getppid, c::SYS_gettid, c::SYS_getuid, c::SYS_geteuid, c::SYS_getgid,
    c::SYS_getegid, c::SYS_getgroups, c::SYS_getresuid, c::SYS_getresgid, c::SYS_getpgid,
    c::SYS_getsid, c::SYS_capget, c::SYS_uname, c::SYS_sysinfo, c::SYS_getrandom,
    // Sockets of the allowed kinds.
    c::SYS_socket, c::SYS_socketpair, c::SYS_bind, c::SYS_connect, c::SYS_listen,
    c::SYS_accept, c::SYS_accept4, c::SYS_getsockname, c::SYS_getpeername, c::SYS_getsockopt,
    c::SYS_setsockopt, c::SYS_sendto, c::SYS_recvfrom, c::SYS_sendmsg, c::SYS_recvmsg,
    c::SYS_sendmmsg, c::SYS_recvmmsg, c::SYS_shutdown,
];

/// The calls that only this processor has: older forms of the above, mostly.
#[cfg(target_arch = "x86_64")]
#[rustfmt::skip]
pub(super) const ALLOWED_HERE: &[c_long] = &[
    c::SYS_open, c::SYS_creat, c::SYS_stat, c::SYS_lstat, c::SYS_access, c::SYS_readlink,
    c::SYS_mkdir, c::SYS_rmdir, c::SYS_unlink, c::SYS_rename, c::SYS_renameat, c::SYS_link,
    c::SYS_symlink, c::SYS_mknod, c::SYS_getdents, c::SYS_dup2, c::SYS_pipe, c::SYS_poll,
    c::SYS_select, c::SYS_epoll_create, c::SYS_epoll_wait, c::SYS_eventfd, c::SYS_signalfd,
    c::SYS_alarm, c::SYS_pause, c::SYS_time, c::SYS_fork, c::SYS_vfork, c::SYS_getpgrp,
    c::SYS_getrlimit, c::SYS_setrlimit, c::SYS_arch_prctl,
];
/// `renameat`; the constant is missing in `libc` for some C libraries.
#[cfg(target_arch = "aarch64")]
pub(super) const ALLOWED_HERE: &[c_long] = &[38];
/// `riscv_hwprobe` and `riscv_flush_icache`; `libc` has no constants for them.
#[cfg(target_arch = "riscv64")]
pub(super) const ALLOWED_HERE: &[c_long] = &[258, 259];
/// There is no filter for any other processor.
#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64", target_arch = "riscv64")))]
pub(super) const ALLOWED_HERE: &[c_long] = &[];
