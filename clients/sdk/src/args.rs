//! The command line that every participant shares.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use clap::{Arg, ArgGroup, ArgMatches, Args, Command, CommandFactory, FromArgMatches};
use rusty_contract::RunName;
use rusty_contract::output::same_file;
use rusty_link::WaitPolicy;

use crate::ClientError;

/// Options of every participant, in a run (`--run`) or on a log (`--log`).
#[derive(Args, Clone, Debug, Default)]
#[command(group = ArgGroup::new("frames").args(["run", "log"]).required(true))]
#[command(
    after_help = "On a log, --out is the file for the answers as CSV, and --beliefs the file for the\nparticles or histogram of a filter. A scorer reads such files. The keys of a run are\nin its folder; with --log, --key-file is the key that `sim-server seal` wrote.\n\nA launcher appends --run, --name, --wait, --launcher and --key-stdin.\nExit codes: 0 done, 1 failed, 2 wrong usage, 3 data was lost, 4 not bit-exact."
)]
pub struct ClientArgs {
    /// Join the run of this name
    #[arg(long, value_name = "NAME")]
    pub run: Option<RunName>,

    /// Work on a log without a server
    #[arg(long, value_name = "PATH")]
    pub log: Option<PathBuf>,

    /// Name in the roster [default: the program's name]
    #[arg(long, value_name = "NAME")]
    pub name: Option<String>,

    /// Waiting method, balanced, spin or block
    #[arg(long, default_value_t, value_name = "HOW", conflicts_with = "log")]
    pub wait: WaitPolicy,

    /// Time limit of joining, s
    #[arg(long, default_value_t = 20.0, value_name = "SECONDS", conflicts_with = "log")]
    pub join_timeout: f64,

    /// Stop joining when the process with this ID has ended
    #[arg(long, value_name = "PID")]
    pub launcher: Option<u32>,

    /// File or folder to write to [default: stdout for answers]
    #[arg(long, value_name = "PATH")]
    pub out: Option<PathBuf>,

    /// Replace existing files
    #[arg(long)]
    pub force: bool,

    /// File with the beliefs of a filter on a log
    #[arg(long, value_name = "FILE", conflicts_with = "run")]
    pub beliefs: Vec<PathBuf>,

    /// Read the keys from this file [default: in the run's folder]
    #[arg(long, value_name = "FILE")]
    pub key_file: Option<PathBuf>,

    /// Read the keys from standard input until it ends
    #[arg(long, conflicts_with = "key_file")]
    pub key_stdin: bool,

    /// The values of all options but `--out`: files that are read, among other things.
    #[arg(skip)]
    pub values: Vec<PathBuf>,
}

/// Invalid arguments, or a request for help.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{text}")]
pub struct Usage {
    /// Text to print: the help, or the fault and the correct form.
    pub text: String,
    /// Exit code: 0 for help, which goes to stdout.
    pub code: i32,
}

/// Returns the name of a program from the first word of its command line.
fn program(word: Option<OsString>) -> String {
    let stem = word.and_then(|w| Some(Path::new(&w).file_stem()?.to_string_lossy().into_owned()));
    stem.unwrap_or_else(|| "client".to_owned())
}

/// The values of all options but `--out`.
fn values(matches: &ArgMatches) -> Vec<PathBuf> {
    let others = matches.ids().filter(|id| *id != "out");
    let raw = others.filter_map(|id| matches.try_get_raw(id.as_str()).ok().flatten());
    raw.flatten().map(PathBuf::from).collect()
}

/// The command line of a participant with the separate options `O`.
fn command<O: Args>(program: String) -> Command {
    let command = Command::new(program).version(env!("CARGO_PKG_VERSION"));
    let about = "Take part in a run of sim-server or work on its log";
    with_negative_numbers(O::augment_args(ClientArgs::augment_args(command).about(about)))
}

/// Takes negative numbers as values of all options: a value that is refused says why.
#[must_use]
pub fn with_negative_numbers(command: Command) -> Command {
    let allow = |arg: Arg| match arg.get_action().takes_values() {
        true => arg.allow_negative_numbers(true),
        false => arg,
    };
    command.mut_args(allow).mut_subcommands(with_negative_numbers)
}

/// Parses this process's command line, with negative numbers as values of all options. Ends the
/// process with the help, or with an error for an invalid command line.
#[must_use]
pub fn parsed<P: CommandFactory + FromArgMatches>() -> P {
    let mut command = with_negative_numbers(P::command());
    let matches = command.get_matches_mut();
    P::from_arg_matches(&matches).unwrap_or_else(|e| e.format(&mut command).exit())
}

impl ClientArgs {
    /// Parses this process's command line. Ends the process with the help, or with an
    /// error for an invalid command line.
    #[must_use]
    pub fn from_command_line() -> Self {
        Self::with_options::<()>().0
    }

    /// Parses this process's command line with the options `O` in addition. Ends the
    /// process as [`from_command_line`](Self::from_command_line).
    #[must_use]
    pub fn with_options<O: Args>() -> (Self, O) {
        let (args, mut options) = Self::with_options_of_runs();
        (args, options())
    }

    /// The same with a function that returns the options for each run.
    pub(crate) fn with_options_of_runs<O: Args>() -> (Self, impl FnMut() -> O) {
        let mut command = command::<O>(program(std::env::args_os().next()));
        let matches = command.get_matches_mut();
        let args = Self::from_arg_matches(&matches);
        let mut args = args.unwrap_or_else(|e| e.format(&mut command).exit());
        args.values = values(&matches);
        let options = move || {
            let options = O::from_arg_matches(&matches);
            options.unwrap_or_else(|e| e.format(&mut command).exit())
        };
        (args, options)
    }

    /// Reads a command line that is not this process's own; the first argument
    /// is the program's name.
    ///
    /// # Errors
    /// [`Usage`] where [`from_command_line`](Self::from_command_line) would end
    /// the process.
    pub fn parse_from(arguments: impl IntoIterator<Item = OsString>) -> Result<Self, Usage> {
        let mut arguments = arguments.into_iter().peekable();
        let command = command::<()>(program(arguments.peek().cloned()));
        let parsed = command.try_get_matches_from(arguments);
        let args = parsed.and_then(|matches| {
            Ok(Self { values: values(&matches), ..Self::from_arg_matches(&matches)? })
        });
        args.map_err(|e| Usage { text: e.render().to_string(), code: e.exit_code() })
    }

    /// Checks that a file which the command line names is not replaced unasked, and neither the
    /// log and key file that are read nor the file of `--out` at all. A launcher chooses files
    /// that are its own to replace.
    ///
    /// # Errors
    /// [`ClientError::InTheWay`] if there is a file already, [`ClientError::Usage`] if it
    /// is one of these.
    pub fn check_free(&self, path: &Path) -> Result<(), ClientError> {
        if self.out.as_ref().is_some_and(|out| out == path || same_file(out, path)) {
            let text = format!("{}: --out has the same file; give another one", path.display());
            return Err(ClientError::Usage(text));
        }
        self.check_replaced(path)
    }

    /// The same for the file of `--out`, if there is one, which is no file of another option
    /// either.
    pub(crate) fn check_out(&self) -> Result<(), ClientError> {
        let Some(out) = &self.out else { return Ok(()) };
        self.check_replaced(out)?;
        if out.is_file() && self.values.iter().any(|value| same_file(value, out)) {
            let text = format!("{}: --out has the file of another option", out.display());
            return Err(ClientError::Usage(format!("{text}; give another one")));
        }
        Ok(())
    }

    fn check_replaced(&self, path: &Path) -> Result<(), ClientError> {
        for (read, what) in [(&self.log, "log"), (&self.key_file, "key file")] {
            if read.as_ref().is_some_and(|read| same_file(read, path)) {
                let path = path.display();
                let text = format!("{path} is the {what} being read; give another file to write");
                return Err(ClientError::Usage(text));
            }
        }
        // Devices and pipes are written to, not replaced.
        let is_file = std::fs::metadata(path).is_ok_and(|found| found.is_file());
        match is_file && !self.force && self.launcher.is_none() {
            true => Err(ClientError::InTheWay { path: path.display().to_string() }),
            false => Ok(()),
        }
    }

    /// Checks that a program without answers and beliefs is asked for no file of them.
    ///
    /// # Errors
    /// [`ClientError::Usage`] and [`ClientError::ShowsNone`] name the option.
    pub fn check_no_answers(&self) -> Result<(), ClientError> {
        if self.log.is_some() && self.out.is_some() {
            let text = "--out: there are no answers to write; leave it out".to_owned();
            return Err(ClientError::Usage(text));
        }
        self.check_no_beliefs()
    }

    /// Checks that a program without beliefs is asked for no file of them: `--beliefs` is for
    /// filters that show any, and for scorers.
    ///
    /// # Errors
    /// [`ClientError::ShowsNone`].
    pub fn check_no_beliefs(&self) -> Result<(), ClientError> {
        match self.beliefs.is_empty() {
            true => Ok(()),
            false => Err(ClientError::ShowsNone(self.name())),
        }
    }

    /// The name in the roster: `--name`, or the program's.
    #[must_use]
    pub fn name(&self) -> String {
        self.name.clone().unwrap_or_else(|| program(std::env::args_os().next()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(arguments: &[&str]) -> Result<ClientArgs, Usage> {
        ClientArgs::parse_from(arguments.iter().map(OsString::from))
    }

    #[test]
    fn a_file_is_replaced_only_if_that_is_asked_for() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("x.csv");
        let free = |args: &[&str], path: &Path| {
            parse(&[&["x", "--log", "l"], args].concat()).unwrap().check_free(path)
        };
        free(&[], &file).unwrap();
        std::fs::write(&file, "").unwrap();
        assert!(matches!(free(&[], &file), Err(ClientError::InTheWay { .. })));
        let other = folder.path().join("y.csv");
        for path in [&file, &other] {
            let out = ["--force", "--out", path.to_str().unwrap()];
            assert!(matches!(free(&out, path), Err(ClientError::Usage(_))), "{path:?}");
        }
        assert!(parse(&["x", "--log", "l", "--out", "y"]).unwrap().check_out().is_ok());
        let key = file.to_str().unwrap();
        let with_key = |out: &str| {
            let args = ["x", "--log", "l", "--key-file", key, "--force", "--out", out];
            parse(&args).unwrap().check_out()
        };
        assert!(matches!(with_key(key), Err(ClientError::Usage(_))));
        assert!(with_key(other.to_str().unwrap()).is_ok());
        // Any file that another option names is read, or written by that option.
        let named = parse(&["x", "--log", "l", "--beliefs", key, "--force", "--out", key]).unwrap();
        assert!(matches!(named.check_out(), Err(ClientError::Usage(_))));
        for (args, path) in [
            (&["--force"][..], file.as_path()),
            (&["--launcher", "1"], &file),
            (&[], folder.path()),
            (&[], Path::new("/dev/null")),
        ] {
            free(args, path).unwrap();
        }
    }

    #[test]
    fn a_program_without_answers_writes_none() {
        let check = |args: &[&str]| parse(&[&["x"], args].concat()).unwrap().check_no_answers();
        check(&["--log", "l"]).unwrap();
        check(&["--run", "lab"]).unwrap();
        let out = check(&["--log", "l", "--out", "y"]);
        assert!(matches!(out, Err(ClientError::Usage(_))), "{out:?}");
        let beliefs = check(&["--log", "l", "--beliefs", "y"]);
        assert!(matches!(beliefs, Err(ClientError::ShowsNone(_))), "{beliefs:?}");
    }

    #[test]
    fn a_negative_number_is_the_value_of_its_option() {
        let args = parse(&["x.py", "--run", "lab", "--join-timeout", "-1"]).unwrap();
        assert_eq!(args.join_timeout, -1.0);
    }

    #[test]
    fn a_command_line_of_others_is_read_or_explained() {
        let args = parse(&["x.py", "--run", "lab", "--name", "me", "--wait", "spin"]).unwrap();
        assert_eq!((args.name(), args.wait), ("me".to_owned(), WaitPolicy::Spin));
        assert_eq!(args.run.unwrap().as_str(), "lab");
        let help = parse(&["x.py", "--help"]).unwrap_err();
        assert!(help.code == 0 && help.text.contains("--join-timeout"), "{help}");
        let version = parse(&["bin/x", "--version"]).unwrap_err();
        assert_eq!(version.text, concat!("x ", env!("CARGO_PKG_VERSION"), "\n"));
        let both = parse(&["x.py", "--run", "lab", "--beliefs", "b"]).unwrap_err();
        assert!(both.code == 2 && both.text.contains("cannot be used with"), "{both}");
        let files = parse(&["score", "--log", "l", "--beliefs", "a", "--beliefs", "b"]).unwrap();
        assert_eq!(files.beliefs.len(), 2);
        let nothing = parse(&["x.py"]).unwrap_err();
        assert!(nothing.code == 2 && nothing.text.contains("--run <NAME>"), "{nothing}");
    }
}
