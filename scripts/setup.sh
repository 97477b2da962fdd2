#!/usr/bin/env bash
# Installs what the checks need beyond Rust and a C compiler: the C libraries of the `system` flavour, cargo-deny, and a browser for the tests of
# the report and the studio (without one they are skipped and say so). The default flavour needs nothing of this. OpenBLAS with threads on
# purpose: the build without them has no locks either, and our threads would have to queue for it (crates/chladni-linalg/src/lapack.rs).
set -euo pipefail

packages=(libopenblas-pthread-dev libhdf5-dev pkg-config)
browsers=(chromium chromium-browser google-chrome google-chrome-stable)

as_root=()
[ "$(id -u)" -eq 0 ] || as_root=(sudo)
install() {
    echo "installing $*"
    "${as_root[@]}" apt-get update -qq
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "$@"
}

missing=()
for package in "${packages[@]}"; do
    dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q '^install ok installed$' || missing+=("$package")
done
if ((${#missing[@]})); then
    install "${missing[@]}"
fi

browser=
for name in "${browsers[@]}"; do
    command -v "$name" >/dev/null && browser=$name && break
done
# letters for the screenshots come with it
[ -n "$browser" ] || install chromium fonts-dejavu-core || echo "no browser could be installed: the tests of the pages will be skipped"

for component in rustfmt clippy; do
    cargo "${component/rust/}" --version >/dev/null 2>&1 || rustup component add "$component"
done

# licences, sources and advisories of the dependencies; where it cannot be had, that check is left out
command -v cargo-deny >/dev/null || timeout 1200 cargo install -q cargo-deny --locked || echo "cargo-deny could not be installed"
