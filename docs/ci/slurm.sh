#!/bin/sh
#SBATCH --job-name=levels
#SBATCH --array=1-16
#SBATCH --cpus-per-task=8
#SBATCH --mem=16G
# Each element builds its part of the folder; run it again to build what is missing.
exec lodc build models -o levels --if-changed --jobs "$SLURM_CPUS_PER_TASK" --limit memory=15G \
    --shard "$SLURM_ARRAY_TASK_ID/$SLURM_ARRAY_TASK_COUNT"
