"""Prints the readings of the small sensors: tick by tick, and as a log has them."""

import json
import math
import sys
import warnings

import rusty

session = rusty.join(*sys.argv[2:], log=sys.argv[1])
ticks = [
    {
        "bumper": tick.bumper,
        "imu": tick.imu,
        "sonars": None if tick.sonars is None else tick.sonars.tolist(),
        "doors": tick.doors,
        "landmarks": None if tick.landmarks is None else tick.landmarks.tolist(),
    }
    for tick in session
]
log = rusty.read_log(sys.argv[1])
# JSON has no NaN.
rows = {
    name: [[None if math.isnan(number) else number for number in row] for row in readings.tolist()]
    for name, readings in log.readings.items()
}
start = session.start
said = {"sheet": start.data_sheet, "dropout": start.lidar.dropout, "sensors": start.sensors}
print(json.dumps({**said, "ticks": ticks, "rows": rows}))
