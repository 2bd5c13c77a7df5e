"""Launches runs from Python: `launches.py SERVER OUT EXAMPLES RUN`; prints two reports."""

import json
import sys
from pathlib import Path

import numpy as np

import rusty

server, out, examples, name = sys.argv[1], Path(sys.argv[2]), Path(sys.argv[3]), sys.argv[4]
particle_filter = [sys.executable, examples / "particle_filter.py"]

# Three estimators in one run.
three = rusty.launch(
    ticks=400,
    seed=3,
    add={
        "python": [sys.executable, examples / "dead_reckoning.py"],
        "particles": particle_filter,
    },
    out=out / "three",
    run=f"{name}a",
    server=server,
)
log = three.log()
assert log.complete and log.digest == three.digest and log.ticks == three.ticks == 400
assert three.seed == log.seed == 3 and three.exit_code == 0 and not three.losses
assert three.score("particles").final_position_error_m == three.scores[2]["final_position_error_m"]
assert [path.exists() for path in three.pictures] == [True] * len(three.pictures)
assert (log.answers["python"] == log.answers["dead-reckoning"]).all()
assert [*log.covariances] == ["particles"]
# The scorer saw its particles; who has none to show leaves no file.
assert (out / "three" / "particles.beliefs").stat().st_size > 10_000
assert not (out / "three" / "python.beliefs").exists()
page = three._repr_html_()
assert "ATE rmse, m" in page and f"<code>{three.digest}</code>" in page
assert page.count("data:image/svg+xml;base64,") == 1
assert "<th>distance_m</th>" in three.scores[0]._repr_html_()
eigenvalues = np.linalg.eigvalsh(log.covariances["particles"])
assert eigenvalues.shape == (400, 3) and (eigenvalues > 0).all()

# A scenario that is written here, with a pose that the filter has to find.
hidden = {
    "name": "hidden",
    "ticks": 60,
    "robot": {"slip_std": np.float64(0.01)},
    "lidar": {"beams": 90},
    "script": {"kind": "straight", "v_m_s": 0.2},
    "participant": [
        {"name": "particles", "command": [*map(str, particle_filter)], "initial_pose": "hidden"},
        {"name": "score", "role": "scorer", "command": ["score"]},
        {"name": "logger", "role": "logger", "command": ["logger"]},
    ],
}
alone = rusty.launch(
    hidden,
    set={"lidar": {"beams": 180}, "robot.slip_std": 0.03, "script": {"kind": "straight", "v_m_s": 0.3}},
    out=out / "hidden",
    run=f"{name}b",
    server=server,
)
config = alone.log().header["config"]
assert config["robot"]["slip_std"] == 0.03 and config["lidar"]["beams"] == 180
assert config["script"] == {"kind": "straight", "v_m_s": 0.3} and alone.seed == 42
print(json.dumps([three.report, alone.report]))

# A run for each robot of a scenario with several.
both = rusty.launch("two-robots", ticks=40, out=out / "both", run=f"{name}c", server=server)
first, second = both.robots
assert first is both and [robot.ticks for robot in both.robots] == [40, 40]
assert first.digest != second.digest and second.log().digest == second.digest
assert "ATE" in repr(second) and second.score("dead-reckoning")["scored_ticks"] == 40

# Nothing is begun that cannot end well.
table = out / "there.csv"
table.write_text("mine")
for wrong, found in [
    ({"retries": -1}, ValueError),
    ({"jobs": 0}, ValueError),
    ({"table": out / "table.txt"}, ValueError),
    ({"table": table}, FileExistsError),
]:
    try:
        rusty.sweep(out / "no-manifest.toml", server=server, **wrong)
        raise AssertionError(f"{wrong} was accepted")
    except found as error:
        assert "expected" in str(error) or "force=True" in str(error), error
