//! The commands of README and handbook: each one is a command of the programs, with
//! options that they have; and the blocks of the pages run, from the first line to the
//! last, with fewer ticks and seeds.

use std::collections::{BTreeMap, BTreeSet};

use std::os::unix::fs::{PermissionsExt as _, symlink};
use std::sync::OnceLock;

use rusty_tests::*;

/// Programs of a build that the pages name.
fn programs() -> &'static [String] {
    static PROGRAMS: OnceLock<Vec<String>> = OnceLock::new();
    PROGRAMS.get_or_init(|| {
        let all = sim_server(&["programs", "--json"]).expect(0).json();
        let names = all.as_array().unwrap().iter().map(|p| text(p, "name").to_owned());
        names.chain(["sim-server".to_owned()]).collect()
    })
}

/// README and the pages of the handbook.
fn pages() -> Vec<String> {
    handbook_pages().into_iter().chain(["README.md".to_owned()]).collect()
}

fn read(page: &str) -> String {
    fs::read_to_string(repository().join(page)).unwrap()
}

/// The lines of a page's shell blocks, whole and without remarks.
fn block_lines(text: &str) -> Vec<String> {
    let blocks = text.split("```sh\n").skip(1).map(|b| b.split("```").next().unwrap());
    let whole = blocks.map(|block| block.replace("\\\n", " "));
    let lines = whole.flat_map(|b| b.lines().map(str::to_owned).collect::<Vec<_>>());
    let plain = lines.map(|line| line.split("  #").next().unwrap().trim().to_owned());
    plain.filter(|line| !line.is_empty()).collect()
}

/// Code within the text that begins with a program.
fn inline(text: &str) -> Vec<String> {
    let prose: String = text.split("```").step_by(2).collect();
    let spans = prose.split('`').skip(1).step_by(2).map(|span| span.replace('\n', " "));
    spans.filter(|span| span.contains(' ') && !span.contains('…')).collect()
}

/// The words of a command after the program, as far as a shell would split them here:
/// brackets mark what may be left out.
fn words(command: &str) -> Vec<String> {
    let plain = command.replace(['[', ']'], " ");
    plain.split_whitespace().map(|w| w.trim_end_matches([',', '.']).to_owned()).collect()
}

fn program(word: &str) -> Option<&'static str> {
    let name = word.rsplit('/').next()?;
    programs().iter().map(String::as_str).find(|program| *program == name)
}

#[derive(Default)]
struct Help(BTreeMap<Vec<String>, String>);

impl Help {
    fn of(&mut self, path: &[&str]) -> &str {
        let key: Vec<String> = path.iter().map(|w| (*w).to_owned()).collect();
        self.0
            .entry(key)
            .or_insert_with(|| execute(path[0], &[&path[1..], &["--help"]].concat()).stdout)
    }

    /// Whether a word is a verb, which has help of its name.
    fn has_verb(&mut self, path: &[&str], word: &str) -> bool {
        let is_word = word.bytes().all(|b| b.is_ascii_lowercase() || b == b'-');
        if !is_word || !self.of(path).contains("Commands:") && path != ["sim-server"] {
            return false;
        }
        let verb = [path, &[word]].concat();
        let usage = [format!("Usage: {}", verb.join(" ")), format!("Usage: {word} ")];
        usage.iter().any(|usage| self.of(&verb).contains(usage))
    }

    /// Says why a command cannot be right.
    fn problem(&mut self, command: &str) -> Option<String> {
        let words = words(command);
        let mut path = vec![program(&words[0])?];
        let mut rest = &words[1..];
        while let Some(word) = rest.first()
            && self.has_verb(&path, word)
        {
            path.push(word);
            rest = &rest[1..];
        }
        if path.len() == 1 && path[0] == "sim-server" && !rest.first()?.starts_with('-') {
            return Some(format!("there is no verb {}", rest[0]));
        }
        // A program that is started by another has options of that one's.
        let own = rest.iter().take_while(|word| *word != "--");
        let quoted = own.scan(false, |inside, word| {
            let begins_inside = *inside;
            *inside ^= word.matches(['"', '\'']).count() % 2 == 1;
            Some((begins_inside, word))
        });
        let options = quoted.filter(|(inside, word)| !inside && word.starts_with("--"));
        for (_, option) in options {
            let option = option.split('=').next().unwrap();
            let help = self.of(&path);
            if !help.split([' ', ',', '\n', '[', ']', '=']).any(|word| word == option) {
                return Some(format!("{} has no option {option}", path.join(" ")));
            }
        }
        None
    }
}

#[test]
fn every_command_of_the_pages_has_its_verb_and_options() {
    let (mut help, mut wrong, mut seen) = (Help::default(), Vec::new(), BTreeSet::new());
    for page in pages() {
        let text = read(&page);
        let commands = block_lines(&text).into_iter().chain(inline(&text));
        for command in commands.flat_map(|c| c.split("&& ").map(str::to_owned).collect::<Vec<_>>())
        {
            let Some(first) = command.split_whitespace().next().and_then(program) else { continue };
            seen.insert(first);
            wrong.extend(help.problem(&command).map(|why| format!("{page}: `{command}`: {why}")));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!(seen.len() >= 12, "few programs found: {seen:?}");
}

/// Words of lines that are not run here, and why.
const NOT_RUN: [(&str, &str); 12] = [
    ("cargo", "other tests build"),
    (".sh ", "CI builds the packages"),
    ("ros2", "the tests of the bridge to ROS 2 run it"),
    ("/opt/ros", "the tests of the bridge to ROS 2 run it"),
    ("serve ", "it waits for participants that are started by hand"),
    ("sudo ", "it changes the machine"),
    ("pip ", "the tests of the Python package install it"),
    ("python", "the tests of the Python package run it"),
    ("intel", "the tests of recordings import and replay it"),
    ("csail", "the tests of recordings import and replay it"),
    ("--watch", "the tests of the viewer open its page"),
    ("view ", "the tests of the viewer open its page"),
];

/// A page's lines as a script that stops at the first failure.
fn script(lines: &[String]) -> String {
    let runs: BTreeSet<String> = lines.iter().flat_map(|l| after(l, "--run")).collect();
    // What still runs in the background after a failure would hold the output open.
    let mut script = String::from("set -e\ntrap 'jobs -p | xargs -r kill' EXIT\n");
    for line in lines {
        if let Some((_, why)) = NOT_RUN.iter().find(|(word, _)| format!("{line} ").contains(word)) {
            script += &format!("# not run, {why}: {line}\n");
            continue;
        }
        let line = small(line);
        let words = line.split(' ').map(|word| renamed(word, &runs)).collect::<Vec<_>>().join(" ");
        // `diff` ends with 4 where it finds a difference.
        let accepted = if line.starts_with("sim-server diff") { " || [ $? = 4 ]" } else { "" };
        script += &format!("{words}{accepted}\n");
    }
    script
}

/// The word after each of these options.
fn after(line: &str, option: &str) -> Option<String> {
    line.split_whitespace().skip_while(|word| *word != option).nth(1).map(str::to_owned)
}

/// Names of runs are those of this process: a reader may have runs of the same names.
fn renamed(word: &str, runs: &BTreeSet<String>) -> String {
    let mine = |name: &str| format!("h{}-{name}", std::process::id());
    if runs.contains(word) {
        return mine(word);
    }
    let folder = word.strip_prefix("runs/").and_then(|path| path.split_once('/'));
    match folder {
        Some((name, path)) if runs.contains(name) => format!("runs/{}/{path}", mine(name)),
        _ => word.to_owned(),
    }
}

/// The line with two seeds, sweeps of a hundred ticks, one scenario of the drivers, and poses
/// that are there.
fn small(line: &str) -> String {
    let mut small = line.replace("/amcl_pose", "/dead_reckoning/pose");
    if let Some(seeds) = after(line, "--seeds") {
        let two = match seeds.split_once("..") {
            Some((from, _)) => format!("{from}..{}", from.parse::<u64>().unwrap() + 2),
            None => "2".to_owned(),
        };
        small = small.replace(&format!("--seeds {seeds}"), &format!("--seeds {two}"));
    }
    if let Some(ticks) = after(line, "--ticks") {
        return small.replace(&format!("--ticks {ticks}"), "--ticks 100");
    }
    // The steps after `sweep plan` have the ticks from the manifest.
    let has_ticks = line.contains("sweep run ") || line.contains("sweep merge ");
    let more = [
        ("sim-server sweep ", " --ticks 100"),
        ("sim-server budget ", " --seeds 0..20"),
        ("--track driving ", " --only errand"),
    ];
    let more = more.iter().filter(|(verb, _)| line.contains(verb) && !has_ticks);
    more.fold(small, |line, (_, more)| line + more)
}

/// A reader's folder: the programs on the path and in `target/release`, a filter, a run
/// named `NAME`, and the files that the pages make or name.
fn prepare(place: &Path, page: &str) {
    let release = place.join("target/release");
    fs::create_dir_all(&release).unwrap();
    let link = |name: &str, to: &str| {
        symlink(binary(to), release.join(name)).unwrap();
    };
    programs().iter().for_each(|name| link(name, name));
    let script = format!("#!/bin/sh\nexec {} \"$@\"\n", binary("dead-reckoning").display());
    for mine in ["target/release/my-filter", "target/release/mine", "my-client"] {
        write(place, mine, &script);
        let mode = fs::Permissions::from_mode(0o755);
        fs::set_permissions(place.join(mine), mode).unwrap();
    }
    symlink(repository().join("clients"), place.join("clients")).unwrap();
    launch("named", &place.join("runs/NAME"), &["--ticks", "300"]);
    if page == "docs/worlds.md" {
        let text = read(page);
        let world = text.split("```toml\n").nth(1).unwrap().split("```").next().unwrap();
        write(place, "box.toml", world);
        let wall = |k: usize| k % 120 < 2 || k % 120 > 117 || !(240..120 * 78).contains(&k);
        let cells: Vec<u8> = (0..120 * 80).map(|k| if wall(k) { 0 } else { 254 }).collect();
        let map = rusty_floorplan::map_server::pgm::write(120, 80, "0.05 m a pixel", &cells);
        write(place, "lab.pgm", map);
        let sheet = "image: lab.pgm\nresolution: 0.05\norigin: [-4.0, -2.0, 0.0]\nnegate: 0\n\
                     occupied_thresh: 0.65\nfree_thresh: 0.25\n";
        write(place, "lab.yaml", sheet);
    }
}

fn run(page: &str) {
    let lines = block_lines(&read(page));
    let outer = folder();
    // Pages name the repository `../rusty` and its parts as seen from there.
    let place = outer.at("rusty");
    prepare(&place, page);
    let script = script(&lines);
    let path = std::env::var("PATH").unwrap();
    let mut shell = Command::new("bash");
    shell.current_dir(&place).args(["-xc", &script]);
    shell.env("PATH", format!("{}:{path}", place.join("target/release").display()));
    let ended = Process::spawn(&mut shell).wait_within(3 * WATCHDOG);
    assert_eq!(ended.code, Some(0), "{page}:\n{script}\n{}\n{}", ended.stdout, ended.stderr);
}

macro_rules! pages {
    ($($test:ident: $page:literal),* $(,)?) => {
        $(#[test]
        fn $test() {
            run($page);
        })*

        #[test]
        fn every_page_with_commands_runs() {
            let run = BTreeSet::from([$($page.to_owned()),*]);
            let with: BTreeSet<String> =
                pages().into_iter().filter(|page| !block_lines(&read(page)).is_empty()).collect();
            assert_eq!(with, run);
        }
    };
}

pages! {
    readme: "README.md",
    benchmark: "docs/benchmark.md",
    chapter: "docs/chapter.md",
    filters: "docs/filters.md",
    first_filter_python: "docs/first-filter-python.md",
    first_filter_rust: "docs/first-filter-rust.md",
    gym: "docs/gym.md",
    install: "docs/install.md",
    protocol: "docs/protocol.md",
    ros: "docs/ros.md",
    ros2_bridge: "docs/ros2-bridge.md",
    scenarios: "docs/scenarios.md",
    sensors: "docs/sensors.md",
    start: "docs/start.md",
    sweeps: "docs/sweeps.md",
    tour: "docs/tour.md",
    view: "docs/view.md",
    widgets: "docs/widgets.md",
    worlds: "docs/worlds.md",
}
