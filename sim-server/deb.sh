#!/usr/bin/env bash
# Builds a Debian package: the binary with its names, pages for `man`, completions.
#
#   sim-server/deb.sh BINARY [OUT]
set -euo pipefail
binary="$(realpath "$1")"
out="$(realpath "${2-.}")"
cd "$(dirname "$0")/.."

stage="$(mktemp -d)"
trap 'rm -rf "$stage"' EXIT
chmod 755 "$stage"
share="$stage/usr/share"
mkdir -p "$stage/DEBIAN" "$stage/usr/bin" "$share/bash-completion/completions" \
    "$share/zsh/vendor-completions" "$share/fish/vendor_completions.d" "$share/doc/rusty-lab"

server="$stage/usr/bin/sim-server"
strip -o "$server" "$binary"
"$server" programs --link "$stage/usr/bin" > /dev/null
# These are files of other packages.
rm "$stage/usr/bin/logger" "$stage/usr/bin/view"
"$server" man "$share/man/man1" > /dev/null
gzip --best --no-name "$share"/man/man1/*
"$server" completions bash > "$share/bash-completion/completions/sim-server"
"$server" completions zsh > "$share/zsh/vendor-completions/_sim-server"
"$server" completions fish > "$share/fish/vendor_completions.d/sim-server.fish"
cp LICENSE-MIT LICENSE-APACHE README.md "$share/doc/rusty-lab"

glibc="$(objdump -T "$server" | grep -o 'GLIBC_2[0-9.]*' | sort -V | tail -1)"
version="$("$server" --version)"
cat > "$stage/DEBIAN/control" << CONTROL
Package: rusty-lab
Version: ${version##* }
Architecture: $(dpkg --print-architecture)
Maintainer: The authors of Rusty's laboratory <rusty-lab@localhost>
Section: science
Priority: optional
Depends: libc6 (>= ${glibc#GLIBC_}), libgcc-s1
Installed-Size: $(du -sk "$stage/usr" | cut -f1)
Description: lockstep robot simulator for measuring state estimation
 A server, filters for comparison, a scorer, a logger and a viewer. A seed, a
 scenario and the commands determine every bit of a run.
CONTROL
dpkg-deb --root-owner-group --build "$stage" "$out"
