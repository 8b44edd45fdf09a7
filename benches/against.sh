#!/bin/sh
# Holds this working tree against a commit: both programs draw the same scenes in turn.
set -eu

usage() {
    cat <<'TEXT'
usage: benches/against.sh COMMIT [SCENE...] [-- OPTION...]

Builds COMMIT in a git worktree under target/against, then renders the scenes (default: those of a few seconds)
with both programs in turn, five pairs each. Prints medians, quartiles and the ratio of this tree's times to the
commit's, says whether rays are equal and pictures the same bits, and how far they are apart if not.

Scenes: see benches/scenes.sh. Options after -- go to `cargo bench`: --repeats N, --json FILE.
TEXT
}

say() { printf '%s\n' "against: $*" >&2; }
fail() { say "$*"; exit 1; }

case "${1:-}" in
-h | --help) usage; exit 0 ;;
'' | --*) usage >&2; exit 2 ;;
esac
unset CDPATH
cd "$(dirname "$0")/.."
commit=$(git rev-parse --verify --quiet "$1^{commit}") || fail "$1 is no commit; \`git log\` lists them"
shift
short=$(git rev-parse --short=9 "$commit")
folder=$PWD/target/against
program=$folder/whitted-$short

scenes=
while [ $# -gt 0 ]; do
    case "$1" in
    --) shift; break ;;
    -*) usage >&2; fail "options come after --" ;;
    *) scenes="$scenes $1" ;;
    esac
    shift
done

if ! [ -x "$program" ]; then
    tree=$folder/tree-$short
    mkdir -p "$folder"
    # A worktree that an interrupted run left is as good as a new one.
    [ -e "$tree/Cargo.toml" ] || git worktree add --force --detach "$tree" "$commit" >&2
    (
        cd "$tree"
        ! [ -e whitted.sh ] || ./whitted.sh setup
        say "building $short"
        # All baselines share the build folder of the dependencies; the same profile as `cargo bench`.
        CARGO_TARGET_DIR=$folder/build cargo build --release --locked --bin whitted >&2
    ) || fail "$short does not build; its worktree is $tree"
    cp "$folder/build/release/whitted" "$program.new"
    mv "$program.new" "$program"
    git worktree remove --force "$tree"
fi
say "this tree is $(git describe --always --dirty), that is $short: $(git log -1 --format=%s "$commit")"
# shellcheck disable=SC2086 # one word per scene
exec cargo bench --locked --bench frames -- $scenes --against "$program" --called "$short" "$@"
