"""Scenarios and changes of Python as the command line takes them."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any, Iterator, Mapping

from ._rusty import toml_document, toml_value


def scenario_file(scenario: str | os.PathLike[str] | Mapping[str, Any], folder: str) -> str:
    """What the command line says of the scenario; a dictionary becomes a file."""
    if not isinstance(scenario, Mapping):
        return os.fspath(scenario)
    whole = dict(scenario)
    # TOML has no larger integer; a scenario takes a seed as text.
    if isinstance(whole.get("seed"), int) and whole["seed"] >= 2**63:
        whole["seed"] = str(whole["seed"])
    # Paths are the caller's, not the temporary file's.
    if whole.get("world_file") is not None:
        whole["world_file"] = os.path.abspath(whole["world_file"])
    script = whole.get("script")
    if isinstance(script, Mapping) and script.get("file") is not None:
        whole["script"] = {**script, "file": os.path.abspath(script["file"])}
    if "participant" in whole:
        whole["participant"] = [
            {**one, "files": [os.path.abspath(f) for f in one["files"]]} if "files" in one else one
            for one in whole["participant"]
        ]
    path = os.path.join(folder, "scenario.toml")
    Path(path).write_text(toml_document(_json(whole)), encoding="utf-8")
    return path


def _json(value: Any) -> str:
    """JSON; what numpy and `pathlib` have is taken for what it means."""

    def plain(other: Any) -> Any:
        if hasattr(other, "tolist"):
            return other.tolist()
        if hasattr(other, "__fspath__"):
            return os.fspath(other)
        raise TypeError(f"{other!r} cannot be part of a scenario")

    return json.dumps(value, default=plain, allow_nan=False)


def changes_of(changes: Mapping[str, Any] | None) -> Iterator[str]:
    """The changes of a scenario as ``--set`` has them."""
    for key, value in _fields(changes or {}):
        try:
            yield f"{key}={toml_value(_json(value))}"
        except ValueError as e:
            raise ValueError(f"set: {key} = {value!r}: {e}") from None


def _fields(changes: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, Any]]:
    """The fields of nested dictionaries, with dotted names."""
    for key, value in changes.items():
        # `kind` says which fields a table has: such a table is set as a whole.
        if isinstance(value, Mapping) and "kind" not in value:
            yield from _fields(value, f"{above}{key}.")
        else:
            yield f"{above}{key}", value
