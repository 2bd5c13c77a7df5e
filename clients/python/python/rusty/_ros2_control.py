"""The services of `simulation_interfaces` on the control requests of a run.

They have the rights of `sim-server control`: the control key is in the folder of the
run, and no participant can control its run, so this is a separate process. Each service
answers as the definition of its interface (version 2.1) requires.
"""

from __future__ import annotations

import json
import time
from typing import Any

from ._ros2_node import QUIET, BridgeError
from ._rusty import RustyError, control

STEP_LIMIT_S = 3600.0
"""How long a step of many ticks may take, s."""
REPLY_LIMIT_S = 10.0
"""How long any other control request may take, s."""
LOOK_S = 1.0
"""How often to look whether the run goes on, s."""


def serve(run: str) -> None:
    """Offers the services until the run has ended."""
    import rclpy

    node = rclpy.create_node("simulator", **QUIET)
    try:
        services = Services(node, run)
    except ImportError as error:
        raise BridgeError(
            f"serving control requests failed: expected the package {error.name}, got none; "
            "install ros-$ROS_DISTRO-simulation-interfaces"
        ) from None
    services.ask("status")
    looked_s = time.monotonic()
    while True:
        rclpy.spin_once(node, timeout_sec=LOOK_S)
        if time.monotonic() - looked_s >= LOOK_S:
            try:
                services.ask("status")
            except RustyError:
                return
            looked_s = time.monotonic()


class Services:
    """Step, pause, resume and stop a run as ROS's simulators are controlled."""

    def __init__(self, node: Any, run: str) -> None:
        from simulation_interfaces import msg, srv

        self.run = run
        self.results, self.states = msg.Result, msg.SimulationState
        self.features, self.set_state = msg.SimulatorFeatures, srv.SetSimulationState
        for kind, name, serve in (
            (srv.StepSimulation, "step_simulation", self.step),
            (srv.SetSimulationState, "set_simulation_state", self.change),
            (srv.GetSimulationState, "get_simulation_state", self.state),
            (srv.GetSimulatorFeatures, "get_simulator_features", self.list_features),
        ):
            node.create_service(kind, f"~/{name}", serve)

    def step(self, request: Any, response: Any) -> Any:
        """Steps a paused run, and replies when its ticks are complete."""

        def step() -> int:
            if not self.ask("status")["paused"]:
                raise BridgeError("step failed: expected a paused run; pause it first")
            if request.steps < 1:
                raise BridgeError("step failed: expected at least 1 step, got 0")
            self.ask({"step": request.steps}, STEP_LIMIT_S)
            return int(self.results.RESULT_OK)

        return self._reply(response, step)

    def change(self, request: Any, response: Any) -> Any:
        """Resumes, pauses or stops the run."""
        requests = {
            self.states.STATE_PLAYING: "resume",
            self.states.STATE_PAUSED: "pause",
            self.states.STATE_QUITTING: "stop",
        }

        def change() -> int:
            target = request.state.state
            if target not in requests:
                response.result.error_message = "a run can be playing, paused or quitting"
                return int(self.results.RESULT_FEATURE_UNSUPPORTED)
            if target == self._current():
                return int(self.set_state.Response.ALREADY_IN_TARGET_STATE)
            self.ask(requests[target])
            return int(self.results.RESULT_OK)

        return self._reply(response, change)

    def state(self, _: Any, response: Any) -> Any:
        """Returns whether the run is playing or paused."""

        def state() -> int:
            response.state.state = self._current()
            return int(self.results.RESULT_OK)

        return self._reply(response, state)

    def list_features(self, _: Any, response: Any) -> Any:
        """Returns what these services can do."""
        known = self.features
        response.features.features = [
            known.SIMULATION_STATE_GETTING,
            known.SIMULATION_STATE_SETTING,
            known.SIMULATION_STATE_PAUSE,
            known.STEP_SIMULATION_SINGLE,
            known.STEP_SIMULATION_MULTIPLE,
        ]
        response.features.custom_info = f"run {self.run} of Rusty's laboratory"
        return response

    def _current(self) -> int:
        paused = self.ask("status")["paused"]
        return int(self.states.STATE_PAUSED if paused else self.states.STATE_PLAYING)

    def ask(self, request: Any, limit_s: float = REPLY_LIMIT_S) -> dict[str, Any]:
        """Sends a control request and returns the status of the run."""
        reply = json.loads(control(self.run, json.dumps(request), limit_s))
        if "Refused" in reply:
            raise BridgeError(f"run {self.run}: {reply['Refused']}")
        status: dict[str, Any] = reply["Status"]
        return status

    def _reply(self, response: Any, work: Any) -> Any:
        """Writes the result of a request into its response."""
        try:
            response.result.result = work()
        except RustyError as error:
            response.result.result = self.results.RESULT_OPERATION_FAILED
            response.result.error_message = str(error)
        return response
