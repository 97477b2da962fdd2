#!/bin/sh
# Builds one fuzz target with the stable compiler and without cargo-fuzz, and runs it.
# Usage: scripts/fuzz.sh TARGET [option of libFuzzer...], for example: scripts/fuzz.sh scene_threshold -runs=1000000 -max_len=2048
set -eu
target=$1
shift
cd "$(dirname "$0")/../fuzz"
host=$(rustc -vV | sed -n 's/^host: //p')
# counters on every edge for libFuzzer, as cargo-fuzz asks for them without a sanitizer
RUSTFLAGS="--cfg fuzzing -Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
-Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table \
-Cllvm-args=-sanitizer-coverage-trace-compares -Ccodegen-units=1" \
    cargo build --release --target "$host" --bin "$target"
mkdir -p "corpus/$target" "artifacts/$target"
exec "${CARGO_TARGET_DIR:-target}/$host/release/$target" "corpus/$target" -artifact_prefix="artifacts/$target/" "$@"
