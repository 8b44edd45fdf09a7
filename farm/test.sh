#!/bin/sh
# Runs the templates of this folder on the real engines, each with a task that fails and one that is cancelled, and
# compares the merged pictures with a single run: every byte must be the same. An engine that is not there and cannot be
# installed is skipped, and that is said. Everything stays on this machine and ends with this script.
#   farm/test.sh [openjd] [slurm] [parallel]     $WHITTED: the program
set -eu
here=$(cd "$(dirname "$0")" && pwd)
WHITTED=${WHITTED:-$here/../target/release/whitted}
WHITTED=$(cd "$(dirname "$WHITTED")" && pwd)/$(basename "$WHITTED")
export WHITTED WHITTED_DEVICE="${WHITTED_DEVICE:-cpu}"
scene=$here/../scenes/cornell_glass.toml
work=$(mktemp -d)
export WORK="$work"
shares=5
options="--size 160x120 --samples 2000 --depth 6 --seed 3 --checkpoint 0.2"
# Seconds that one engine may take.
limit=${FARM_TEST_SECONDS:-420}
failed=0

say() { printf '%s\n' "farm: $*" >&2; }
have() { command -v "$1" >/dev/null 2>&1; }

clean() {
    [ ! -e "$work/slurm/slurm.conf" ] || sh "$here/slurm/one-node.sh" stop "$work/slurm"
    rm -rf "$work"
}
trap clean EXIT
trap 'exit 130' INT TERM

# Stands for the program on a bad machine: the first time that share 2 is asked for, it fails.
bad() {
    cat >"$work/bad" <<'BAD'
#!/bin/sh
case "$*" in
*"--share 2/"*) [ -e "$WORK/failed-once" ] || { : >"$WORK/failed-once"; echo "a bad machine" >&2; exit 1; } ;;
esac
# The number of this process, which the program takes over.
echo "$$" >"$WORK/pid"
exec "$WHITTED" "$@"
BAD
    chmod +x "$work/bad"
    rm -f "$work/failed-once"
}

# What a report counts: rays and faults.
counts() {
    sed -n -e '/^  "rays": {/,/^  "passes"/p' -e '/^  "counters": {/,/^  }/p' "$1"
}

# $1: the engine; its picture against that of one run.
same() {
    cmp "$work/$1.exr" "$work/whole.exr" || { say "$1: the picture differs"; return 1; }
    [ "$(counts "$work/$1.exr.json")" = "$(counts "$work/whole.json")" ] || { say "$1: the counts differ"; return 1; }
    say "$1: merged from $shares shares, one failed and one cancelled and made good: the same bytes, the same counts"
}

# Waits until a share of engine $1 has a state, so that there is something to go on from.
until_kept() {
    for _ in $(seq 600); do
        for state in "$work/$1.exr.shares"/*.partial; do [ ! -e "$state" ] || return 0; done
        sleep 0.1
    done
    say "$1: no state was written"
    return 1
}

# True if some share of engine $1 left a state.
left() {
    for state in "$work/$1.exr.shares"/*.partial; do [ ! -e "$state" ] || return 0; done
    say "$1: the cancelled task left no state"
    return 1
}

openjd_run() {
    timeout -k 20 "$limit" "$openjd" run "$here/openjd/whitted.yaml" --step Merge --run-dependencies -p "Scene=$scene" \
        -p "Out=$work/openjd.exr" -p "Shares=$shares" -p "Options=$options" -p "Program=$1"
}

test_openjd() {
    if have openjd; then
        openjd=openjd
    elif have python3 && python3 -m venv "$work/venv" 2>/dev/null &&
        "$work/venv/bin/pip" install -q 'openjd-cli>=0.8,<0.9' >"$work/pip.log" 2>&1; then
        openjd=$work/venv/bin/openjd
    else
        say "openjd: SKIPPED, since openjd-cli cannot be installed by pip"
        return 0
    fi
    "$openjd" check "$here/openjd/whitted.yaml" >/dev/null
    bad
    # Cancelled: the runner passes the signal on, and the task saves its state.
    openjd_run "$work/bad" >"$work/openjd.1.log" 2>&1 &
    job=$!
    until_kept openjd
    kill -TERM "$(pgrep -P "$job" | head -n 1)" 2>/dev/null || kill -TERM "$job"
    wait "$job" && { say "openjd: the cancelled job claims success"; return 1; }
    left openjd
    # Failed: share 2 on its bad machine.
    if openjd_run "$work/bad" >"$work/openjd.2.log" 2>&1; then say "openjd: the failure was not seen"; return 1; fi
    [ ! -e "$work/openjd.exr" ] || { say "openjd: merged without a share"; return 1; }
    openjd_run "$work/bad" >"$work/openjd.3.log" 2>&1 || { cat "$work/openjd.3.log" >&2; return 1; }
    grep -q 'openjd_progress: 100' "$work/openjd.3.log" || { say "openjd: no progress was told"; return 1; }
    same openjd
}

# Waits until Slurm has no job left.
slurm_done() {
    for _ in $(seq "$((limit * 2))"); do
        [ -n "$(squeue -h)" ] || return 0
        sleep 0.5
    done
    say "slurm: jobs do not end"
    squeue >&2
    return 1
}

test_slurm() {
    if ! have slurmctld && have apt-get && [ "$(id -u)" = 0 ]; then
        DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends slurmctld slurmd slurm-client munge \
            >"$work/apt.log" 2>&1 || true
    fi
    if ! have slurmctld || ! have slurmd || ! have munged || [ "$(id -u)" != 0 ]; then
        say "slurm: SKIPPED, since slurmctld, slurmd, slurm-client and munge are not installed, or this is not root"
        return 0
    fi
    mkdir "$work/slurm"
    sh "$here/slurm/one-node.sh" start "$work/slurm"
    export SLURM_CONF="$work/slurm/slurm.conf"
    bad
    good=$WHITTED
    # shellcheck disable=SC2086 # options are words
    submit() { (cd "$work" && "$here/slurm/submit.sh" "$scene" "$work/slurm.exr" "$shares" $options); }
    # The array job inherits the environment: the bad machine stands for the program there, and calls the good one.
    sed -i "s|\"\$WHITTED\"|\"$good\"|" "$work/bad"
    WHITTED=$work/bad submit >"$work/job"
    until_kept slurm
    # The task that runs now is cancelled; others go on, and the merging job is never started.
    scancel "$(squeue -h -t R -o %i | head -n 1)"
    slurm_done
    [ -e "$work/failed-once" ] || { say "slurm: share 2 was not tried"; return 1; }
    [ ! -e "$work/slurm.exr" ] || { say "slurm: merged without a share"; return 1; }
    left slurm
    WHITTED=$work/bad submit >"$work/job"
    slurm_done
    sh "$here/slurm/one-node.sh" stop "$work/slurm"
    [ -e "$work/slurm.exr" ] || { cat "$work/slurm.exr.shares"/*.log >&2; return 1; }
    same slurm
}

test_parallel() {
    if ! have parallel && have apt-get && [ "$(id -u)" = 0 ]; then
        DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends parallel >"$work/apt.log" 2>&1 || true
    fi
    have parallel || { say "parallel: SKIPPED, since GNU parallel is not installed"; return 0; }
    bad
    mkdir "$work/parallel.exr.shares"
    # shellcheck disable=SC2086 # options are words
    one() {
        (cd "$work/parallel.exr.shares" && timeout -k 20 "$limit" parallel --will-cite --jobs 1 --joblog log --resume-failed \
            "$work/bad" render "$scene" $options -q --resume --share "{}/$shares" -o "{}.share" ::: $(seq "$shares"))
    }
    one &
    job=$!
    until_kept parallel
    kill -TERM "$(cat "$work/pid")"
    wait "$job" && { say "parallel: the failure was not seen"; return 1; }
    left parallel
    one || { say "parallel: not made good"; return 1; }
    "$WHITTED" merge -q "$work/parallel.exr.shares"/*.share -o "$work/parallel.exr" \
        --report "$work/parallel.exr.json"
    same parallel
}

[ -x "$WHITTED" ] || { say "no program at $WHITTED"; exit 1; }
# shellcheck disable=SC2086 # options are words
"$WHITTED" render "$scene" $options -q -o "$work/whole.exr" --report "$work/whole.json"
[ $# -gt 0 ] || set -- openjd slurm parallel
for engine in "$@"; do
    # Not as a condition, which would make `set -e` mean nothing. A failure does not keep the others from being tried.
    (trap - EXIT; "test_$engine") &
    wait "$!" || { failed=1; say "$engine: FAILED"; }
done
exit "$failed"
