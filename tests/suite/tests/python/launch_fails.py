"""What a launch raises: `launch_fails.py SERVER OUT RUN`."""

import os
import pickle
import sys

import rusty

server, out, name = sys.argv[1:]
count = 0


def launch(*args, **more):
    global count
    count += 1
    usual = {"server": server, "ticks": 30, "force": True}
    return rusty.launch(*args, out=f"{out}/run", run=f"{name}{count}", **{**usual, **more})


def raised(kind, words, *args, **more):
    try:
        launch(*args, **more)
    except kind as error:
        assert words in str(error), error
        return error
    raise AssertionError(f"{words!r} was not raised")


assert raised(rusty.LaunchError, "built-in scenarios: apartment", "attic").exit_code == 2
assert raised(rusty.LaunchError, "unknown field `beems`", set={"lidar.beems": 3}).exit_code == 2
assert raised(rusty.LaunchError, "unknown field `tocks`", {"tocks": 3}).run is None
raised(ValueError, "TOML has no null", {"world_file": None, "start": None})
quote = raised(rusty.LaunchError, "has a quote without an end", add={"a": "my 'program"})
assert quote.exit_code == 2
raised(FileNotFoundError, "no program that can be run", server=out)
failing = {"fails": [sys.executable, "-c", "raise SystemExit(7)"]}
error = raised(rusty.LaunchError, "exited with code 7", add=failing)
assert error.exit_code == 1 and error.run.report["ended"] == "aborted"
# A run that lost something is no run, unless it is asked for.
going_on = {"on_loss": "continue"}
error = raised(rusty.RunLost, "exited with code 7", add=failing, set=going_on)
assert error.exit_code == 3 and error.run.ticks == 30
again = pickle.loads(pickle.dumps(error))
assert type(again) is rusty.RunLost and str(again) == str(error) and again.exit_code == 3
assert again.run.report == error.run.report and again.run.losses[0].name == "fails"
kept = launch(add=failing, set=going_on, allow_loss=True)
assert kept.exit_code == 3 and [loss.name for loss in kept.losses] == ["fails"]
assert kept.score("dead-reckoning").scored_ticks == 30
blind = launch(without=["logger"])
assert blind.log_path is None
# Without server=: on the path, else as built here or above, else a remedy.
os.environ["PATH"] = ""
os.chdir(out)
raised(FileNotFoundError, "cargo build --release", server=None)
os.makedirs("target/release")
os.makedirs("deep/er")
os.symlink(server, "target/release/sim-server")
os.chdir("deep/er")
assert launch(server=None).exit_code == 0
