#!/usr/bin/env bash
# Builds the wheel with all programs: the Python package, `sim-server`, and a script for
# each client in it.
#
#   clients/python/wheel.sh [OUT]                 for Linux with glibc 2.28 or newer; needs
#                                                 `pip install maturin ziglang cargo-zigbuild`
#   clients/python/wheel.sh --binary FILE [OUT]   for this machine only, with a binary that
#                                                 is built already and an unoptimised module
set -euo pipefail
built=
if [ "${1-}" = --binary ]; then
    built="$(realpath "$2")"
    shift 2
fi
out="$(realpath "${1-.}")"
cd "$(dirname "$0")"
root="$(realpath ../..)"

target="$(rustc -vV | sed -n 's/^host: //p')"
binary="${built:-${CARGO_TARGET_DIR:-$root/target}/$target/dist/sim-server}"
if [ -z "$built" ]; then
    # Together with the module, which is then made of the same builds of other crates.
    cargo zigbuild --profile dist --manifest-path "$root/Cargo.toml" -p sim-server -p rusty-python \
        --bin sim-server --target "$target.2.28"
fi

# Pip puts these files on the path, next to python.
scripts="rusty_lab.data/scripts"
trap 'rm -rf rusty_lab.data' EXIT
rm -rf rusty_lab.data
mkdir -p "$scripts"
strip -o "$scripts/sim-server" "$binary"
for client in $("$binary" programs | sed '1d; s/ .*//'); do
    # These would hide programs of the system.
    case "$client" in logger | view) continue ;; esac
    printf '#!/bin/sh\nexec "${0%%/*}/sim-server" %s "$@"\n' "$client" > "$scripts/$client"
done
chmod +x "$scripts"/*

if [ -z "$built" ]; then
    maturin build --profile dist --zig --compatibility manylinux_2_28 --target "$target" --out "$out"
else
    # As pip builds it, in the profile of the tests.
    MATURIN_PEP517_ARGS="--profile dev" \
        python3 -m pip wheel --quiet --no-deps --wheel-dir "$out" .
fi
