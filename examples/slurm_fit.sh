#!/usr/bin/env bash
# A fit in pieces as jobs of a SLURM cluster (docs/pieces.md): two passes over the blocks, each an array job, each followed by one job that
# merges and solves.
#
#   bash slurm_fit.sh scan.h5 64        # on a login node; the file where all nodes see it; writes model.json beside it
#
# Memory of a task: a block (file size / number of blocks) twice over, and half a gigabyte. Blocks are numbered from 0.
set -euo pipefail

frf=$(realpath "$1")
blocks=${2:-64}
cd "$(dirname "$frf")"
mkdir -p parts
rm -f parts/*.part # of another number of blocks

submit() { # DEPENDENCY ("" for none) NAME COMMAND [OPTION...]
    local after=$1 name=$2 command=$3
    shift 3
    sbatch --parsable --job-name "$name" --output "parts/%x-%j.log" --kill-on-invalid-dep=yes \
        ${after:+--dependency=afterok:$after} "$@" --wrap "set -eu; $command"
}
pass() { # DEPENDENCY NAME [OPTION OF REDUCE...]
    local after=$1 name=$2
    shift 2
    local part="parts/$name-\$(printf %04d \$SLURM_ARRAY_TASK_ID).part"
    submit "$after" "$name" "chladni block reduce '$frf' --blocks $blocks --block \$SLURM_ARRAY_TASK_ID --threads 1 --force $* -o $part" \
        --array "0-$((blocks - 1))" --cpus-per-task 1 --mem 4G
}
solve() { # DEPENDENCY NAME OUTPUT
    submit "$1" "solve-$2" "chladni block merge parts/$2-*.part --force -o parts/$2.part; chladni block solve parts/$2.part --force -o $3" \
        --cpus-per-task 4 --mem 8G
}

first=$(pass "" first)
poles=$(solve "$first" first parts/found.poles)
second=$(pass "$poles" second --poles parts/found.poles)
model=$(solve "$second" second model.json)
echo "model.json: job $model, after $second, $poles, $first (squeue --me; logs in parts/)"

# Afterwards, for FRFs that were not part of it:   chladni block residues MORE.h5 --model model.json -o more.json
# A job `solve-second` that fails with exit code 1 has written model.json, which is not to be trusted, or model.poles: poles that the
# second pass asks for, to be given to a further one (--poles). Its log says which, and why.
