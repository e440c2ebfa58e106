#!/bin/sh
# Renders a scene as an array of Slurm jobs, one for each shard, and merges the shards in a last job that waits for them.
set -eu
if [ $# -lt 2 ]; then
    echo "usage: submit.sh SCENE SHARDS [OPTION OF 'superegg render' ...]" >&2
    exit 2
fi
scene=$1 shards=$2
shift 2
jobs=$(cd "$(dirname "$0")" && pwd)
name=$(basename "$scene" .scn)
mkdir -p "$name.parts"

render=$(sbatch --parsable --job-name="$name" --array="1-$shards" --output="$name.parts/%a.log" \
    "$jobs/render.sbatch" "$scene" "$shards" "$name.parts" "$@")
merge=$(sbatch --parsable --job-name="$name-merge" --output="$name.parts/merge.log" \
    --dependency="afterok:${render%%;*}" --kill-on-invalid-dep=yes "$jobs/merge.sbatch" "$name.parts" "$shards" "$name.png")
echo "jobs ${render%%;*} (shards 1-$shards) and ${merge%%;*} (merge) make $name.png"
