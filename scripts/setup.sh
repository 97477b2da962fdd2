#!/usr/bin/env bash
# Installs what the checks need beyond Rust and a C compiler: the C libraries of the `system` flavour.
# The default flavour needs nothing of this. OpenBLAS with threads on purpose: the build without them has no locks either, and our
# threads would have to queue for it (crates/chladni-linalg/src/lapack.rs).
set -euo pipefail

packages=(libopenblas-pthread-dev libhdf5-dev pkg-config)
missing=()
for package in "${packages[@]}"; do
    dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q '^install ok installed$' || missing+=("$package")
done
if ((${#missing[@]})); then
    echo "installing ${missing[*]}"
    as_root=()
    [ "$(id -u)" -eq 0 ] || as_root=(sudo)
    "${as_root[@]}" apt-get update -qq
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}"
fi
for component in rustfmt clippy; do
    cargo "${component/rust/}" --version >/dev/null 2>&1 || rustup component add "$component"
done
