//! A file system of shared memory that is small, full, or fills during a run: the
//! run has its bits, or does not start and reports how much it needs.

use rusty_tests::*;

/// Runs a script in which `/dev/shm` is a separate file system of `size`, with
/// the arguments of a launch as `"$@"`; `None`, with a printed reason, where that
/// is not allowed.
fn with_memory(size: &str, script: &str, launch: &[&str]) -> Option<(Ended, Folder)> {
    let mount = format!("mount -t tmpfs -o size={size} tmpfs /dev/shm");
    let can = Command::new("unshare").args(["-m", "sh", "-c", &mount]).output();
    if !can.as_ref().is_ok_and(|tried| tried.status.success()) {
        skipped(&format!("/dev/shm cannot be mounted anew here: {can:?}"));
        return None;
    }
    let out = folder();
    let mut command = Command::new("unshare");
    command.args(["-m", "sh", "-c", &format!("{mount} && {script}"), "sh"]);
    command.arg(binary("sim-server")).args(["launch", "--json", "--force", "--out"]);
    command.arg(out.path()).args(launch);
    Some((Process::spawn(&mut command).wait(), out))
}

#[test]
fn a_run_has_its_bits_or_reports_how_much_memory_it_needs() {
    let script = "\"$@\"; code=$?; ls -A /dev/shm/rusty-* 2>/dev/null; exit $code";
    let mut digests = Vec::new();
    for size in ["4k", "64k", "300k", "1m", "2m", "3m", "5m", "7m", "9m", "11m", "13m", "64m"] {
        let Some((ended, _out)) = with_memory(size, script, &["--ticks", "50"]) else { return };
        match ended.code {
            Some(0) => digests.push(text(&ended.json(), "digest").to_owned()),
            Some(1) => {
                assert!(ended.stderr.contains("/dev/shm"), "{size}: {}", ended.stderr);
                assert_eq!(ended.stdout, "", "{size}: files are left");
            }
            _ => panic!("{size}: {ended:?}"),
        }
    }
    // 13 MB, and what a container has by default.
    assert_eq!(digests.len(), 2);
    assert_eq!(digests[0], digests[1]);
}

#[test]
fn a_run_under_way_does_not_mind_that_others_fill_the_memory() {
    let undisturbed = launch("undisturbed", folder().path(), &["--ticks", "200"]);
    let run = fresh_run("filled");
    // Full after the first ticks. No port can be opened then.
    let script = format!(
        "\"$@\" & until \"$1\" control {run} step >&2; do sleep 0.02; done; \
         \"$1\" control {run} resume >&2; \
         cat /dev/zero > /dev/shm/fill 2>/dev/null; \
         rest=$(df --output=avail /dev/shm | tail -n 1); \
         \"$1\" control {run} status >&2; refused=$?; \
         wait $!; code=$?; [ $rest -eq 0 ] && [ $refused -eq 1 ] && exit $code"
    );
    let paused = ["--ticks", "200", "--pace", "1", "--paused", "--run", run.as_str()];
    let Some((ended, _out)) = with_memory("64m", &script, &paused) else { return };
    ended.says("shared memory is full");
    assert_eq!(ended.expect(0).json()["digest"], undisturbed["digest"]);
}
