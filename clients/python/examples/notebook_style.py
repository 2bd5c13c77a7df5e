"""A run from a notebook: launch, look at the scores, look into the log.

Cells begin with ``# %%`` (VS Code, Spyder, Jupytext). Run it where ``sim-server``
is on the PATH, or below the folder in which it was built.
"""

# %% A whole run, next to the filter of this folder; ``sys.executable`` is this Python
import sys
from pathlib import Path

import numpy as np

import rusty

particle_filter = Path(__file__).with_name("particle_filter.py")
run = rusty.launch(
    "apartment",
    seed=7,
    ticks=500,
    set={"robot.slip_std": 0.05},
    add={"particle-filter": [sys.executable, particle_filter]},
)
print(run)

# %% The scores, one per estimator
for score in run.scores:
    print(f"{score.name:16} ATE {score.ate_rmse_m:.4f} m, final {score.final_position_error_m:.4f} m")

# %% The log as arrays: errors of the answers, and what the covariances say of them
log = run.log()
for name, poses in log.answers.items():
    errors_m = np.hypot(*(poses[:, :2] - log.truth[:, :2]).T)
    print(f"{name:16} worst {np.nanmax(errors_m):.4f} m at {log.time_s[np.nanargmax(errors_m)]:.2f} s")

# %% A model compared with the data: what the first scan would be without noise
world, lidar = log.world(), log.header["config"]["lidar"]
expected_m = world.scan(log.truth[log.scan_ticks[0]], lidar)
residual_m = (log.ranges[0] - expected_m)[log.ranges[0] < lidar["range_max_m"]]
print(f"first scan: {len(residual_m)} beams, residual {residual_m.std():.4f} m")
