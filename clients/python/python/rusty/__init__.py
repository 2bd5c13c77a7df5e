"""Take part in a run of Rusty's laboratory."""

from ._rusty import LAYOUT_HASH, PROTOCOL_VERSION, __version__

__all__ = ["LAYOUT_HASH", "PROTOCOL_VERSION", "__version__"]
