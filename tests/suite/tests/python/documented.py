"""Whatever the package offers says what it is, to `help()` and notebooks."""

import inspect

import rusty


def public(kind):
    """What a class of ours has under its own names."""
    inherited = [n for base in kind.__mro__[1:] for n in vars(base)]
    return [n for n in vars(kind) if not n.startswith("_") and n not in inherited]


bare, looked_at = [], 0
for name in rusty.__all__:
    it = getattr(rusty, name)
    if isinstance(it, (int, str)):
        continue
    offered = {name: it}
    if inspect.isclass(it):
        offered |= {f"{name}.{member}": getattr(it, member) for member in public(it)}
    looked_at += len(offered)
    bare += [n for n, one in offered.items() if not (one.__doc__ or "").strip()]
    bare += [n for n, one in offered.items() if "the stubs" in (one.__doc__ or "")]
assert not bare, bare
assert looked_at > 80, looked_at
for words, doc in {
    "truth = estimate [+] tau": rusty.Tick.answer.__doc__,
    "(walls, 4)": rusty.Start.map.__doc__,
    "os.fork()": rusty.Tick.ranges.__doc__,
    "SystemExit": rusty.join.__doc__,
    "rad/s": rusty.Robot.wheel_limit_rad_s.__doc__,
    "sensor frame": rusty.Lidar.bearings_rad.__doc__,
}.items():
    assert words in doc, doc
print("documented")
