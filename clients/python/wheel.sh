#!/usr/bin/env bash
# Builds the wheel with all programs: the Python package, the module of `rusty.gym`,
# `sim-server`, and a script for each client in it. Needs `pip install wheel`, which adds
# them to maturin's wheel.
#
#   clients/python/wheel.sh [OUT]                 for Linux with glibc 2.28 or newer; needs
#                                                 `pip install maturin ziglang cargo-zigbuild`
#   clients/python/wheel.sh --binary FILE MODULE WHEEL [OUT]   of a binary, the library of
#                                                 rusty-gym, and a wheel without them
set -euo pipefail
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
gym_stub="$(realpath "$(dirname "$0")/../../sim-server/gym/python/rusty/_gym.pyi")"

if [ "${1-}" = --binary ]; then
    binary="$(realpath "$2")"
    gym="$(realpath "$3")"
    wheel="$(realpath "$4")"
    out="$(realpath "${5-.}")"
else
    out="$(realpath "${1-.}")"
    cd "$(dirname "$0")"
    target="$(rustc -vV | sed -n 's/^host: //p')"
    export CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-$PWD/../../target}"
    maturin build --profile dist --zig --compatibility manylinux_2_28 --target "$target" \
        --out "$work/module"
    wheel="$(echo "$work"/module/*.whl)"
    cargo zigbuild --profile dist --manifest-path ../../Cargo.toml -p sim-server \
        -p rusty-gym --target "$target.2.28"
    binary="$CARGO_TARGET_DIR/$target/dist/sim-server"
    gym="$CARGO_TARGET_DIR/$target/dist/lib_gym.so"
fi

python3 -m wheel unpack --dest "$work" "$wheel"
package="$(echo "$work"/rusty_lab-*)"
# Pip puts these files on the path, next to python.
scripts="$package/$(basename "$package").data/scripts"
mkdir -p "$scripts"
strip -o "$scripts/sim-server" "$binary"
strip -o "$package/rusty/_gym.abi3.so" "$gym"
cp "$gym_stub" "$package/rusty/"
for client in $("$binary" programs | sed '1d; s/ .*//'); do
    # These would hide programs of the system.
    case "$client" in logger | view) continue ;; esac
    printf '#!/bin/sh\nexec "${0%%/*}/sim-server" %s "$@"\n' "$client" > "$scripts/$client"
done
chmod +x "$scripts"/*
python3 -m wheel pack --dest-dir "$out" "$package"
