"""What evo says of an estimated trajectory beside the true one, as JSON.

Usage: python measure.py TRUTH.tum ESTIMATE.tum

The same as `evo_ape tum` and `evo_rpe tum` with their options for translation
(`-r trans_part`) and rotation (`-r angle_rad`), without their printing:
  none      evo_ape                       origin     evo_ape --align_origin
  se2       evo_ape --align
  per_tick  evo_rpe --delta 1 -u f        per_metre  evo_rpe --delta 1 -u m
evo_rpe has --pairs_from_reference.
"""

import copy
import json
import sys

from evo.core import metrics, sync
from evo.core.units import Unit
from evo.tools import file_interface

RELATIONS = {
    "translation_m": metrics.PoseRelation.translation_part,
    "rotation_rad": metrics.PoseRelation.rotation_angle_rad,
}


def statistics(metric, truth, estimate):
    metric.process_data((truth, estimate))
    figures = {name: float(value) for name, value in metric.get_all_statistics().items()}
    return {"count": len(metric.error), **figures}


def absolute(truth, estimate, align):
    moved = copy.deepcopy(estimate)
    if align == "origin":
        moved.align_origin(truth)
    elif align == "se2":
        moved.align(truth, correct_scale=False)
    return {
        name: statistics(metrics.APE(relation), truth, moved)
        for name, relation in RELATIONS.items()
    }


def relative(truth, estimate, unit):
    return {
        name: statistics(
            metrics.RPE(relation, delta=1.0, delta_unit=unit, pairs_from_reference=True),
            truth,
            estimate,
        )
        for name, relation in RELATIONS.items()
    }


def main():
    truth, estimate = (file_interface.read_tum_trajectory_file(path) for path in sys.argv[1:3])
    truth, estimate = sync.associate_trajectories(truth, estimate)
    json.dump(
        {
            "ate": {align: absolute(truth, estimate, align) for align in ("none", "origin", "se2")},
            "rpe": {
                "per_tick": relative(truth, estimate, Unit.frames),
                "per_metre": relative(truth, estimate, Unit.meters),
            },
        },
        sys.stdout,
    )


main()
