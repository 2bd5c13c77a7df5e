//! What a process has from its parent: limits, signal actions, names of folders.

use std::ffi::OsStr;
use std::os::unix::ffi::OsStrExt as _;
use std::os::unix::fs::PermissionsExt as _;

use rusty_tests::*;

/// Launches a run from a shell, after `first`.
fn launched(first: &str, run: &RunName, out: &Path, args: &[&str]) -> Ended {
    let all = [&["launch", "--ticks", "20", "--json", "--run", run.as_str()], args, &["--out"]];
    let mut shell = shell(&format!("{first} \"$0\" \"$@\""), "sim-server", &all.concat());
    Process::spawn(shell.arg(out)).wait()
}

#[test]
fn a_parent_that_ignores_the_ends_of_children_changes_nothing() {
    let (place, run) = (folder(), fresh_run("ignored"));
    // The end of a participant is noticed, too.
    let ended = launched("trap '' CHLD; exec", &run, &place.at("out"), &["patrol"]).expect(0);
    assert_eq!(ended.json()["remarks"].as_array().unwrap().len(), 0, "{ended:#?}");
    let (bad, out) = (["--add", "bad=/bin/false"], place.at("bad"));
    let ignoring = "trap '' CHLD; exec";
    launched(ignoring, &run, &out, &bad)
        .expect(1)
        .says("lost: bad dead: its process exited with code 1");
    nothing_left(&run);
}

#[test]
fn a_limit_that_is_too_low_is_named_with_its_option() {
    let (place, run) = (folder(), fresh_run("limit"));
    let cases = [("-n", "16"), ("-n", "48"), ("-n", "64"), ("-f", "0"), ("-f", "8"), ("-f", "999")];
    for (option, limit) in cases {
        let out = place.at("out");
        let ended =
            launched(&format!("ulimit {option} {limit};"), &run, &out, &["patrol"]).expect(1);
        assert!(ended.stderr.contains(&format!("ulimit {option}")), "{option} {limit}: {ended:#?}");
        assert!(!out.exists(), "{option} {limit}");
        nothing_left(&run);
    }
    let least = place.at("least");
    launched("ulimit -n 94; ulimit -f 65536;", &run, &least, &["patrol"]).expect(0);
    // A soft limit is raised.
    let soft = place.at("soft");
    launched("ulimit -S -n 16;", &run, &soft, &["patrol"]).expect(0);
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
        let (run, out) = (fresh_run("processes"), place.at(processes));
        let first = format!("exec {as_nobody} prlimit --nproc={processes}");
        let ended = launched(&first, &run, &out, &["patrol"]).expect(1);
        assert!(ended.stderr.contains("ulimit -u"), "{processes}: {ended:#?}");
        let left = Path::new("/tmp/rusty-65534").join(run.as_str());
        assert!(!left.exists(), "{processes}");
    }
}

#[test]
fn a_folder_whose_path_is_not_text_is_refused_before_anything_is_written() {
    let (place, run) = (folder(), fresh_run("bytes"));
    let odd = place.at(OsStr::from_bytes(b"odd\xff"));
    launched("exec", &run, &odd, &["patrol"]).expect(2).says("--out");
    // So is one inside such a folder.
    fs::create_dir(&odd).unwrap();
    launched("exec", &run, &odd.join("out"), &["patrol"]).expect(2);
    assert_eq!(fs::read_dir(&odd).unwrap().count(), 0);
    assert_eq!(fs::read_dir(place.path()).unwrap().count(), 1);
    nothing_left(&run);
}
