//! Sweeps in shards from Python: on this machine, with Ray and with Slurm, whatever is
//! killed.

use std::os::unix::fs::PermissionsExt as _;

use rusty_tests::python::{python, script};
use rusty_tests::ray::ray;
use rusty_tests::*;

/// Shards that take longer than a killer needs to notice them.
const SWEEP: [&str; 7] =
    ["patrol", "--seeds", "0..30", "--ticks", "100000", "--set", "scan_every=0"];
const SHARDS: usize = 4;

/// A line of shell that kills a process once the runs of a shard are under way: they are
/// made in a second thread.
fn killed(process: &str) -> String {
    format!(
        "(while [ -e /proc/$$ ] && [ ! -e \"$(ls -d /proc/$$/task/* | sed -n 2p)\" ]; do \
         sleep 0.01; done; kill -9 {process}) &"
    )
}

struct Place {
    folder: Folder,
    manifest: PathBuf,
}

impl Place {
    #[track_caller]
    fn plan() -> Self {
        let folder = folder();
        let manifest = folder.at("m.toml");
        let shards = SHARDS.to_string();
        let plan = ["sweep", "plan", "--shards", &shards, "-o", arg(&manifest)];
        sim_server(&[&plan[..], &SWEEP].concat()).expect(0);
        Self { folder, manifest }
    }

    fn program(&self, name: &str, text: &str) -> String {
        let path = self.folder.write(name, text);
        fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
        path
    }

    /// A `sim-server` in whose first try of each shard this line of shell is run.
    fn server(&self, line: &str) -> String {
        let tries = self.folder.at("tries");
        fs::create_dir(&tries).unwrap();
        let (tries, program) = (tries.display(), binary("sim-server"));
        let text = format!(
            "#!/bin/sh\nfor word; do case $word in --shard=*) shard=${{word#*=}};; esac; done\n\
             if [ -n \"$shard\" ]; then\n  echo x >> {tries}/$shard\n  \
             if [ $(wc -l < {tries}/$shard) = 1 ]; then\n    {line}\n  fi\nfi\n\
             exec {} \"$@\"\n",
            program.display()
        );
        self.program("server", &text)
    }

    /// How often each shard was tried.
    fn tries(&self) -> Vec<usize> {
        let file = |shard| self.folder.at(format!("tries/{shard}"));
        let text = |shard| fs::read_to_string(file(shard)).unwrap_or_default();
        (0..SHARDS).map(|shard| text(shard).lines().count()).collect()
    }

    /// Runs the script to its end.
    #[track_caller]
    fn sweep(&self, mut python: Command, engine: &str, server: &str, more: &[&str]) -> Ended {
        python.args([&script("sweeps.py"), engine, arg(&self.manifest), server]).args(more);
        Process::spawn(python.current_dir(self.folder.path())).wait()
    }

    /// Fails unless the table has the bytes of the sweep in one process.
    #[track_caller]
    fn is_whole(&self, table: &Path) {
        let alone = self.folder.at("alone.parquet");
        sim_server(&[&["sweep"], &SWEEP[..], &["--out", arg(&alone)]].concat()).expect(0);
        assert!(fs::read(table).unwrap() == fs::read(alone).unwrap(), "another table");
    }
}

#[test]
fn a_pool_makes_the_table_of_one_process_though_each_shard_is_killed_once() {
    let Some(python) = python() else { return };
    let place = Place::plan();
    let server = place.server(&killed("$$"));
    let table = place.folder.at("t.parquet");
    let to = format!("table={}", table.display());
    let ended = place.sweep(Command::new(python), "local", &server, &[&to]).expect(0);
    ended.says("4 of 4 shards").prints("4 parts");
    assert_eq!(place.tries(), [2; SHARDS]);
    place.is_whole(&table);
}

#[test]
fn what_does_not_get_better_is_not_tried_again() {
    let Some(python) = python() else { return };
    let place = Place::plan();
    let text = fs::read_to_string(&place.manifest).unwrap();
    fs::write(&place.manifest, text.replace("0..30", "0..31")).unwrap();
    let server = place.server(":");
    let ended = place.sweep(Command::new(python), "local", &server, &[]).expect(12);
    ended.prints("was changed").prints("sweep plan");
    // The first that fails ends the others, some before their first line.
    assert_eq!(place.tries().into_iter().max(), Some(1));
    // And what might is, but not without end.
    fs::write(&place.manifest, text).unwrap();
    fs::remove_dir_all(place.folder.at("tries")).unwrap();
    let server = place.server("echo no room >&2; exit 1");
    let ended = place.sweep(Command::new(python), "local", &server, &["retries=0"]).expect(11);
    ended.prints("no room");
}

#[test]
fn ray_makes_the_table_of_one_process_though_each_worker_is_killed_once() {
    let place = Place::plan();
    let Some(ray) = ray(&place.folder) else { return };
    // The worker that started the shard.
    let server = place.server(&killed("$PPID"));
    let table = place.folder.at("t.parquet");
    let options = [
        format!("table={}", table.display()),
        format!("temp={}", place.folder.at("ray").display()),
    ];
    let options = options.each_ref().map(String::as_str);
    let ended = place.sweep(ray, "ray", &server, &options).expect(0);
    ended.says("4 of 4 shards").prints("4 parts");
    assert_eq!(place.tries(), [2; SHARDS]);
    place.is_whole(&table);
}

/// Runs the script for each index of its array, as Slurm does.
const SBATCH: &str = "#!/bin/sh
for script; do :; done
range=$(sed -n 's/^#SBATCH --array=0-//p' \"$script\")
for i in $(seq 0 \"$range\"); do SLURM_ARRAY_TASK_ID=$i sh \"$script\" || exit 1; done
";

#[test]
fn the_script_for_slurm_makes_every_shard() {
    let Some(python) = python() else { return };
    let place = Place::plan();
    let bin = place.folder.at("bin");
    fs::create_dir(&bin).unwrap();
    place.program("bin/sbatch", SBATCH);
    let path = format!("{}:{}", bin.display(), std::env::var("PATH").unwrap());
    let mut python = Command::new(python);
    python.env("PATH", path);
    let program = binary("sim-server");
    let table = place.folder.at("t.parquet");
    let to = format!("table={}", table.display());
    place.sweep(python, "slurm", arg(&program), &[&to]).expect(0).prints("4 parts");
    place.is_whole(&table);
    let text = fs::read_to_string(place.folder.at("m.parts/sweep.sbatch")).unwrap();
    assert!(text.contains("\n#SBATCH --array=0-3\n") && text.contains("\n#SBATCH --requeue\n"));
}

#[test]
fn a_cluster_with_slurm_makes_every_shard() {
    let Some(python) = python() else { return };
    let has_nodes = Command::new("sinfo").args(["--noheader", "--states=idle,mix"]).output();
    if !has_nodes.is_ok_and(|found| found.status.success() && !found.stdout.is_empty()) {
        return skipped("`sinfo` names no node of a Slurm cluster");
    }
    let place = Place::plan();
    let (program, table) = (binary("sim-server"), place.folder.at("t.parquet"));
    let to = format!("table={}", table.display());
    let ended = place.sweep(Command::new(python), "slurm", arg(&program), &[&to]).expect(0);
    ended.prints("4 parts");
    place.is_whole(&table);
}

#[test]
fn the_job_for_kubernetes_has_every_shard() {
    let Some(python) = python() else { return };
    let place = Place::plan();
    let ended = place.sweep(Command::new(python), "kubernetes", "", &[]).expect(0);
    let job = ended.json();
    assert_eq!(job["spec"]["completions"], 4);
    assert_eq!(job["spec"]["completionMode"], "Indexed");
    let codes = &job["spec"]["podFailurePolicy"]["rules"][0]["onExitCodes"]["values"];
    assert_eq!(codes, &serde_json::json!([2, 4]));
    // The command of a pod, with the volume of this machine.
    let pod = &job["spec"]["template"]["spec"]["containers"][0]["command"];
    let command =
        pod[2].as_str().unwrap().replace("/sweep/", &format!("{}/", place.folder.path().display()));
    let bin = binary("sim-server");
    let path = format!("{}:{}", bin.parent().unwrap().display(), std::env::var("PATH").unwrap());
    let mut shell = Command::new("sh");
    shell.args(["-c", &command]).env("PATH", path).env("JOB_COMPLETION_INDEX", "3");
    Process::spawn(&mut shell).wait().expect(0).says("shard 3 of 4");
}
