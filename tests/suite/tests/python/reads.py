"""Reads a log, says what it is, and leaves its arrays as files of bytes."""

import json
import sys
import warnings
from pathlib import Path

import rusty

path, out = sys.argv[1], Path(sys.argv[2])
with warnings.catch_warnings(record=True) as warned:
    warnings.simplefilter("always")
    try:
        log = rusty.read_log(path)
    except (OSError, rusty.RustyError) as error:
        print(json.dumps({"error": type(error).__name__, "text": str(error)}))
        raise SystemExit(0)
arrays = {"time_s": log.time_s, "counts": log.encoders, "commands": log.commands}
arrays.update(scan_ticks=log.scan_ticks, ranges=log.ranges)
if log.truth is not None:
    arrays["truth"] = log.truth
arrays.update({f"answers-{name}": poses for name, poses in log.answers.items()})
arrays.update({f"covariances-{name}": all for name, all in log.covariances.items()})
arrays.update({f"innovations-{name}": all for name, all in log.innovations.items()})
for name, array in arrays.items():
    (out / name).write_bytes(array.tobytes())
said = {
    "shapes": {name: array.shape for name, array in arrays.items()},
    "digest": log.digest,
    "complete": log.complete,
    "damaged": log.damaged_ticks.tolist(),
    "seed": log.seed,
    "scenario": log.scenario,
    "roster": log.header["roster"],
    "walls": None if log.world() is None else len(log.world().walls),
    "warnings": [f"{w.category.__name__}: {w.message}" for w in warned],
}
print(json.dumps(said))
