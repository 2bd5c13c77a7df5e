"""``python -m rusty``: versions, and the layout of what lies in shared memory."""

from __future__ import annotations

import platform

import numpy

import rusty


def main() -> None:
    """Prints one line for each version."""
    print(f"rusty {rusty.__version__}")
    print(f"protocol {rusty.PROTOCOL_VERSION}")
    print(f"layout {rusty.LAYOUT_HASH:016x}")
    print(f"python {platform.python_version()}")
    print(f"numpy {numpy.__version__}")


if __name__ == "__main__":
    main()
