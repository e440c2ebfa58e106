#!/bin/sh
# Renders a scene as an array of Slurm jobs, one for each share, and merges the shares in a last job that waits for them.
set -eu
if [ $# -lt 2 ]; then
    echo "usage: submit.sh SCENE SHARES [OPTION OF 'superegg render' ...]" >&2
    exit 2
fi
scene=$1 shares=$2
shift 2
jobs=$(cd "$(dirname "$0")" && pwd)
name=$(basename "$scene" .scn)
mkdir -p "$name.parts"

render=$(sbatch --parsable --job-name="$name" --array="1-$shares" --output="$name.parts/%a.log" \
    "$jobs/render.sbatch" "$scene" "$shares" "$name.parts" "$@")
merge=$(sbatch --parsable --job-name="$name-merge" --output="$name.parts/merge.log" \
    --dependency="afterok:${render%%;*}" --kill-on-invalid-dep=yes "$jobs/merge.sbatch" "$name.parts" "$shares" "$name.png")
echo "jobs ${render%%;*} (shares 1-$shares) and ${merge%%;*} (merge) make $name.png"
