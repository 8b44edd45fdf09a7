#!/bin/sh
# A picture in shares on Slurm: an array job of one task per share, then a job that merges them.
#   farm/slurm/submit.sh SCENE OUT SHARES [OPTIONS of whitted render]...
# Run again, it submits only the shares that are missing: failed and cancelled ones go on from their state. Prints the
# number of the merging job. $WHITTED is the program, $SBATCH_OPTIONS go to each sbatch.
set -eu
[ $# -ge 3 ] || { sed -n '2,5s/^# *//p' "$0" >&2; exit 2; }
scene=$1 out=$2 count=$3
shift 3
here=$(dirname "$0")
mkdir -p "$out.shares"
missing=
for share in $(seq "$count"); do
    [ -e "$out.shares/$share.share" ] || missing="$missing${missing:+,}$share"
done
after=
if [ -n "$missing" ]; then
    # shellcheck disable=SC2086 # options are words
    array=$(sbatch --parsable ${SBATCH_OPTIONS:-} --array="$missing" --output="$out.shares/%a.log" --open-mode=append \
        "$here/share.sbatch" "$scene" "$out.shares" "$count" "$@")
    after="--dependency=afterok:$array"
fi
# shellcheck disable=SC2086
sbatch --parsable ${SBATCH_OPTIONS:-} $after --kill-on-invalid-dep=yes --output="$out.shares/merge.log" \
    "$here/merge.sbatch" "$out"
