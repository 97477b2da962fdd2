#!/usr/bin/env bash
# Writes what a program makes of a fixed set of inputs, with a list of checksums: run it
# with the program of before and of after a redesign, then compare the two lists.
#
#   scripts/record_results.sh target/release/chladni results-after
#   diff results-before/SHA256 results-after/SHA256
#
# Times are cut from tables. Real measurements are taken from ../shared/data where present.
set -uo pipefail
program=$(realpath "$1"); mkdir -p "$2"; folder=$(realpath "$2")
root=$(cd "$(dirname "$0")/.." && pwd)
data="$root/../shared/data"
cd "$folder"

# run NAME ARGUMENTS...: what is printed, and the exit code
run() {
    local name=$1; shift
    "$program" "$@" --progress none > "$name.out" 2> "$name.err"
    echo "exit $?" >> "$name.err"
}

mkdir -p in
run simulate simulate "$root/fixtures/panel.toml" -o in/panel.h5 --truth in/truth.json --force
run simulate-driving simulate "$root/fixtures/panel-driving-points.toml" -o in/driving.uff --force
for kind in viscous-beam:pyuff-beam/beam.uff housing:pyuff-uff-samples/heat_engine_housing.uff \
    case1:vtb-case1/case1_frf.csv; do
    [ -f "$data/${kind#*:}" ] && cp "$data/${kind#*:}" "in/${kind%%:*}.${kind##*.}"
done

for method in auto lean vf lscf plscf aaa rfp grfp peak circle; do
    run "panel-$method" fit in/panel.h5 -o "panel-$method.json" --method $method --force
done
for threads in 1 2; do
    run "driving-$threads" fit in/driving.uff --threads $threads -o "driving-$threads.json" --force
done
run viscous fit in/panel.h5 --damping viscous -o viscous.json --force
run band fit in/panel.h5 --band 50:300 --modes 6 -o band.json --force
run scene-band fit in/panel.h5 --scene "$root/fixtures/scene-corner.toml" -o scene-band.json --force
for file in in/viscous-beam.uff in/housing.uff in/case1.csv; do
    [ -f "$file" ] || continue
    name=$(basename "${file%.*}")
    run "info-$name" info "$file" --json
    run "fit-$name" fit "$file" --frf-kind accelerance -o "fit-$name.json" --force
    run "fit-$name-json" fit "$file" --frf-kind accelerance --json
done
for blocks in 1 3; do
    for block in $(seq 0 $((blocks - 1))); do
        run "reduce-$blocks-$block" block reduce in/panel.h5 --block $block --blocks $blocks \
            -o "first-$blocks-$block.part" --force
    done
    run "merge-$blocks" block merge first-$blocks-*.part -o "first-$blocks.part" --force
    run "poles-$blocks" block solve "first-$blocks.part" -o "found-$blocks.poles" --force
    for block in $(seq 0 $((blocks - 1))); do
        run "second-$blocks-$block" block reduce in/panel.h5 --block $block --blocks $blocks \
            --poles "found-$blocks.poles" -o "second-$blocks-$block.part" --force
    done
    run "merged-$blocks" block merge second-$blocks-*.part -o "second-$blocks.part" --force
    run "pieces-$blocks" block solve "second-$blocks.part" -o "pieces-$blocks.json" --force
done
run streamed fit in/panel.h5 --memory 30M -o streamed.json --force
for method in default fast mls modal; do
    run "render-$method" render panel-auto.json "$root/fixtures/scene-corner.toml" \
        --method $method -o "weights-$method.json" --force
done
run report report panel-auto.json weights-default.json -o report.html --charts charts --force
run accuracy bench accuracy --quick -o bench --no-knobs
for table in bench/accuracy.csv bench/accuracy-modes.csv; do
    [ -f $table ] && python3 -c "
import csv, re, sys
rows = [row for row in csv.reader(sys.stdin) if row and not row[0].startswith('#')]
cut = re.compile('(^|_)(time|cpu)(_|$)|_s$|^on_front$')
kept = [k for k, name in enumerate(rows[0]) if not cut.search(name)]
print('\\n'.join(','.join(row[k] for k in kept) for row in rows))" < $table > "$table.no-times"
done

find . -type f ! -name '*.out' ! -path './bench/*' ! -name SHA256 -o -name '*.no-times' \
    | sort | xargs sha256sum > SHA256
