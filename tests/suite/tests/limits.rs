//! What a process has from its parent: limits, signal actions, names of folders.

use std::ffi::OsStr;
use std::fs;
use std::os::unix::ffi::OsStrExt as _;
use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;
use std::process::Command;

use rusty_contract::RunName;
use rusty_tests::*;

/// Launches a short run from a shell, after `first`.
fn launched(first: &str, run: &RunName, out: &Path) -> Ended {
    let mut shell = Command::new("sh");
    shell.args(["-c", &format!("{first} \"$0\" \"$@\"")]).arg(binary("sim-server"));
    shell.args(["launch", "patrol", "--ticks", "20", "--json", "--run", run.as_str(), "--out"]);
    Process::spawn(shell.arg(out)).wait()
}

#[test]
fn a_parent_that_ignores_the_ends_of_children_changes_nothing() {
    let (place, run) = (folder(), fresh_run("ignored"));
    // The end of a participant is noticed, too.
    let ended = launched("trap '' CHLD; exec", &run, &place.path().join("out")).expect(0);
    assert_eq!(ended.json()["remarks"].as_array().unwrap().len(), 0, "{ended:#?}");
    let mut shell = Command::new("sh");
    shell.args(["-c", "trap '' CHLD; exec \"$0\" \"$@\""]).arg(binary("sim-server"));
    shell.args(["launch", "--ticks", "20", "--json", "--add", "bad=/bin/false"]);
    shell.args(["--run", run.as_str(), "--out"]).arg(place.path().join("bad"));
    let ended = Process::spawn(&mut shell).wait().expect(1);
    assert!(ended.stderr.contains("lost: bad dead: its process exited with code 1"), "{ended:#?}");
    nothing_left(&run);
}

#[test]
fn a_limit_that_is_too_low_is_named_with_its_option() {
    let (place, run) = (folder(), fresh_run("limit"));
    let cases = [("-n", "16"), ("-n", "48"), ("-n", "64"), ("-f", "0"), ("-f", "8"), ("-f", "999")];
    for (option, limit) in cases {
        let out = place.path().join("out");
        let ended = launched(&format!("ulimit {option} {limit};"), &run, &out).expect(1);
        assert!(ended.stderr.contains(&format!("ulimit {option}")), "{option} {limit}: {ended:#?}");
        assert!(!out.exists(), "{option} {limit}");
        nothing_left(&run);
    }
    let least = place.path().join("least");
    launched("ulimit -n 94; ulimit -f 65536;", &run, &least).expect(0);
    // A soft limit is raised.
    let soft = place.path().join("soft");
    launched("ulimit -S -n 16;", &run, &soft).expect(0);
    nothing_left(&run);
}

#[test]
fn a_user_without_processes_left_is_told_so() {
    let nobody = ["setpriv", "--reuid", "65534", "--regid", "65534", "--clear-groups"];
    let may = |program: &Path| {
        let mut command = Command::new(nobody[0]);
        let tried = command.args(&nobody[1..]).arg(program).arg("--version").output();
        tried.is_ok_and(|output| output.status.success())
    };
    if !may(&binary("sim-server")) {
        skipped("no other user can be had for it, or cannot execute the binaries");
        return;
    }
    let place = folder();
    fs::set_permissions(place.path(), fs::Permissions::from_mode(0o777)).unwrap();
    let as_nobody = nobody.join(" ");
    for processes in ["1", "2", "3"] {
        let (run, out) = (fresh_run("processes"), place.path().join(processes));
        let first = format!("exec {as_nobody} prlimit --nproc={processes}");
        let ended = launched(&first, &run, &out).expect(1);
        assert!(ended.stderr.contains("ulimit -u"), "{processes}: {ended:#?}");
        let left = Path::new("/tmp/rusty-65534").join(run.as_str());
        assert!(!left.exists(), "{processes}");
    }
}

#[test]
fn a_folder_whose_path_is_not_text_is_refused_before_anything_is_written() {
    let (place, run) = (folder(), fresh_run("bytes"));
    let odd = place.path().join(OsStr::from_bytes(b"odd\xff"));
    let ended = launched("exec", &run, &odd).expect(2);
    assert!(ended.stderr.contains("--out"), "{ended:#?}");
    // So is one inside such a folder.
    fs::create_dir(&odd).unwrap();
    launched("exec", &run, &odd.join("out")).expect(2);
    assert_eq!(fs::read_dir(&odd).unwrap().count(), 0);
    assert_eq!(fs::read_dir(place.path()).unwrap().count(), 1);
    nothing_left(&run);
}
