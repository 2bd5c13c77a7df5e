"""A launch that is interrupted: `launch_stops.py SERVER OUT RUN`."""

import sys

import rusty

server, out, name = sys.argv[1:]
try:
    rusty.launch(ticks=100_000, pace=1, out=out, run=name, server=server)
except KeyboardInterrupt:
    print("interrupted")
