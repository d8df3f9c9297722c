#!/bin/sh
# An experiment as a Slurm array: sbatch assets/cluster/slurm.sh table-2
# Every task takes each n-th cell. All write to one shared folder; a task that is killed is simply submitted again.
# Afterwards: torquescope experiment collect table-2 --out "$OUT"
#SBATCH --job-name=torquescope
#SBATCH --array=1-5
#SBATCH --cpus-per-task=2
#SBATCH --mem=4G
#SBATCH --time=02:00:00
#SBATCH --requeue
set -eu
OUT="${OUT:-experiments}"
exec "${TORQUESCOPE:-torquescope}" experiment run "$@" --out "$OUT" \
    --shard "${SLURM_ARRAY_TASK_ID}/${SLURM_ARRAY_TASK_COUNT}"
