"""Calls the services of simulators on a run. Types of the shape of `simulation_interfaces`
2.1 take the place of the package, with the numbers of its definitions."""

import json
import sys
import types


def kind(**constants):
    return type("Kind", (types.SimpleNamespace,), constants)


name = "simulation_interfaces"
package, msg, srv = (types.ModuleType(f"{name}{end}") for end in ("", ".msg", ".srv"))
msg.Result = kind(RESULT_FEATURE_UNSUPPORTED=0, RESULT_OK=1, RESULT_OPERATION_FAILED=4)
msg.SimulationState = kind(STATE_STOPPED=0, STATE_PLAYING=1, STATE_PAUSED=2, STATE_QUITTING=3)
msg.SimulatorFeatures = kind(
    SIMULATION_STATE_GETTING=24,
    SIMULATION_STATE_SETTING=25,
    SIMULATION_STATE_PAUSE=26,
    STEP_SIMULATION_SINGLE=31,
    STEP_SIMULATION_MULTIPLE=32,
)
for name in ("StepSimulation", "SetSimulationState", "GetSimulationState", "GetSimulatorFeatures"):
    setattr(srv, name, kind(Response=kind(ALREADY_IN_TARGET_STATE=101)))
package.msg, package.srv = msg, srv
sys.modules |= {m.__name__: m for m in (package, msg, srv)}

from rusty._ros2_control import Services  # noqa: E402
from rusty._rusty import control  # noqa: E402


class Node:
    """Keeps the services that it is given."""

    def __init__(self):
        self.services = {}

    def create_service(self, kind, name, serve):
        self.services[name] = serve


node, run = Node(), sys.argv[1]
Services(node, run)


def call(name, **request):
    response = types.SimpleNamespace(
        result=types.SimpleNamespace(result=None, error_message=""),
        state=types.SimpleNamespace(state=None),
        features=types.SimpleNamespace(features=None, custom_info=""),
    )
    return node.services[f"~/{name}"](types.SimpleNamespace(**request), response)


def ask(target):
    return call("set_simulation_state", state=types.SimpleNamespace(state=target)).result.result


def ticks():
    return json.loads(control(run, json.dumps("status"), 10.0))["Status"]["ticks_done"]


playing = call("step_simulation", steps=1)
assert playing.result.result == 4 and "pause" in playing.result.error_message, playing
assert call("get_simulation_state").state.state == 1
assert (ask(1), ask(2), ask(2)) == (101, 1, 101)
assert call("get_simulation_state").state.state == 2
before = ticks()
assert call("step_simulation", steps=3).result.result == 1
assert ticks() == before + 3
assert call("step_simulation", steps=0).result.result == 4
assert ask(0) == 0
assert call("get_simulator_features").features.features == [24, 25, 26, 31, 32]
assert (ask(1), ask(2)) == (1, 1)
assert ask(3) == 1
print("served")
