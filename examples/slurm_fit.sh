#!/usr/bin/env bash
# A fit in pieces as jobs of a SLURM cluster (docs/pieces.md): passes over the blocks, each an array job, each followed by one job that
# merges and solves, and that submits the next pass as long as another is needed.
#
#   bash slurm_fit.sh scan.h5 64        # on a login node; the file where all nodes see it; writes model.json beside it
#
# Memory of a task: a block (file size / number of blocks) twice over, and half a gigabyte. Blocks are numbered from 0.
# Jobs must be allowed to submit jobs.
set -euo pipefail

script=$(realpath "$0")
frf=$(realpath "$1")
blocks=${2:-64}
pass=${3:-1} # later passes: the number of the pass; its poles are in parts/PASS.poles
cd "$(dirname "$frf")"
mkdir -p parts
[ "$pass" = 1 ] && rm -f parts/* model.poles # of another number of blocks

next=$((pass + 1))
case $pass in
    1) poles="" solved="chladni block solve parts/1.part --force -o parts/2.poles" ;;
    *) poles="--poles parts/$pass.poles"
       solved="chladni block solve parts/$pass.part --force -o model.json || mv model.poles parts/$next.poles" ;;
esac

reduce="chladni block reduce '$frf' --blocks $blocks --block \$SLURM_ARRAY_TASK_ID --threads 1 --force $poles"
reduced=$(sbatch --parsable --job-name "pass-$pass" --output "parts/%x-%j.log" --array "0-$((blocks - 1))" --cpus-per-task 1 --mem 4G \
    --wrap "set -eu; $reduce -o parts/$pass-\$(printf %04d \$SLURM_ARRAY_TASK_ID).part")

merge="chladni block merge parts/$pass-*.part --force -o parts/$pass.part"
again="[ ! -e parts/$next.poles ] || bash '$script' '$frf' $blocks $next"
job=$(sbatch --parsable --job-name "solve-$pass" --output "parts/%x-%j.log" --kill-on-invalid-dep=yes --dependency "afterok:$reduced" \
    --cpus-per-task 4 --mem 8G --wrap "set -eu; $merge; $solved; $again")
echo "pass $pass: job $job after $reduced (squeue --me; logs in parts/)"

# Afterwards, for FRFs that were not part of it:   chladni block residues MORE.h5 --model model.json -o more.json
# A job `solve-N` that fails has written model.json, which is not to be trusted. Its log says why.
