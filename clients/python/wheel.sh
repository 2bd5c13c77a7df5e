#!/usr/bin/env bash
# Builds the wheel with all programs: the Python package, `sim-server`, and a script for
# each client in it. Needs `pip install wheel`, which adds them to maturin's wheel.
#
#   clients/python/wheel.sh [OUT]                 for Linux with glibc 2.28 or newer, and a
#                                                 wheel of the module of `rusty.gym`; needs
#                                                 `pip install maturin ziglang cargo-zigbuild`
#   clients/python/wheel.sh --binary FILE WHEEL [OUT]   of a binary and a wheel without it
set -euo pipefail
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT

if [ "${1-}" = --binary ]; then
    binary="$(realpath "$2")"
    wheel="$(realpath "$3")"
    out="$(realpath "${4-.}")"
else
    out="$(realpath "${1-.}")"
    cd "$(dirname "$0")"
    target="$(rustc -vV | sed -n 's/^host: //p')"
    export CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-$PWD/../../target}"
    for manifest in ../../sim-server/gym/Cargo.toml Cargo.toml; do
        maturin build --profile dist --zig --compatibility manylinux_2_28 --target "$target" \
            --manifest-path "$manifest" --out "$work/module"
    done
    # Few need it, and one wheel of both would be larger than 12 MB.
    mv "$work"/module/rusty_lab_gym-*.whl "$out"
    wheel="$(echo "$work"/module/*.whl)"
    cargo zigbuild --profile dist --manifest-path ../../Cargo.toml -p sim-server \
        --target "$target.2.28"
    binary="$CARGO_TARGET_DIR/$target/dist/sim-server"
fi

python3 -m wheel unpack --dest "$work" "$wheel"
package="$(echo "$work"/rusty_lab-*)"
# Pip puts these files on the path, next to python.
scripts="$package/$(basename "$package").data/scripts"
mkdir -p "$scripts"
strip -o "$scripts/sim-server" "$binary"
for client in $("$binary" programs | sed '1d; s/ .*//'); do
    # These would hide programs of the system.
    case "$client" in logger | view) continue ;; esac
    printf '#!/bin/sh\nexec "${0%%/*}/sim-server" %s "$@"\n' "$client" > "$scripts/$client"
done
chmod +x "$scripts"/*
python3 -m wheel pack --dest-dir "$out" "$package"
