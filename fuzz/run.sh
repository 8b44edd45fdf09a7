#!/bin/sh
# Runs libFuzzer over the readers, each from its kept corpus.
#   fuzz/run.sh SECONDS [READER...]   for so long in all; inputs that break a reader are left in fuzz/found
#   fuzz/run.sh keep [READER...]      renews fuzz/corpus from what was found since
# Any Rust builds it: coverage is a pass of LLVM. $FUZZ_BYTES: greatest length of an input.
set -eu
cd "$(dirname "$0")/.."

build=target/fuzz
inputs=$build/inputs
bytes=${FUZZ_BYTES:-4096}
most=200
all='scene obj mtl gltf ply stl nff picture state hierarchy truth records report'

say() { printf '%s\n' "fuzz: $*" >&2; }

usage() {
    sed -n '2,5s/^# \{0,1\}//p' fuzz/run.sh >&2
    exit 2
}

build_readers() {
    host=$(rustc -vV | sed -n 's/^host: //p')
    # As cargo-fuzz has it, without the sanitizer, which needs a nightly Rust.
    RUSTFLAGS='-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table -Cllvm-args=-sanitizer-coverage-trace-compares' \
        cargo build --release --locked --manifest-path fuzz/Cargo.toml --target "$host" --target-dir $build </dev/null
    reader=$PWD/$build/$host/release/reader
    export RAYON_NUM_THREADS=1
}

# The corpus of $1 as files, with what was found before.
unpack() {
    mkdir -p "$inputs/$1"
    tar -xf "fuzz/corpus/$1.tar" -C "$inputs/$1"
}

fuzz() {
    seconds=$1
    shift
    failed=
    each=$(((seconds + $# - 1) / $#))
    for name; do
        unpack "$name"
        mkdir -p "fuzz/found/$name"
        words=fuzz/dictionaries/$name.dict
        [ -e "$words" ] && words=-dict=$words || words=
        log=$build/$name.log
        # shellcheck disable=SC2086 # no dictionary is no word
        if READER=$name "$reader" "$inputs/$name" $words -max_total_time="$each" -max_len="$bytes" -timeout=20 \
            -rss_limit_mb=2048 -artifact_prefix="fuzz/found/$name/" -print_final_stats=1 >"$log" 2>&1 </dev/null; then
            say "$name: $(sed -n 's/^stat::number_of_executed_units: *//p' "$log") inputs"
        else
            failed="$failed $name"
            say "$name FAILED: $log"
            grep -a -m 1 -A 8 -e panicked -e 'ERROR: libFuzzer' "$log" >&2 || tail -n 20 "$log" >&2
        fi
    done
    find fuzz/found -type d -empty -delete
    [ -z "$failed" ] || { say "broken:$failed; the inputs are in fuzz/found"; exit 1; }
}

# A small set of inputs with the coverage of all, of which $most of all sizes are packed, so that equal sets are equal files.
keep() {
    for name; do
        unpack "$name"
        rm -rf "$inputs/$name.kept"
        mkdir -p "$inputs/$name.kept"
        READER=$name "$reader" -merge=1 -max_len="$bytes" "$inputs/$name.kept" "$inputs/$name" >"$build/$name.log" 2>&1 </dev/null
        (
            cd "$inputs/$name.kept"
            # shellcheck disable=SC2012 # names are hashes
            ls -S -r | awk -v most=$most '{ name[NR] = $0 }
                END { for (i = 0; i < most && i < NR; i++) print name[1 + int(i * (NR > most ? NR / most : 1))] }' | LC_ALL=C sort >../names
            tar --owner=0 --group=0 --numeric-owner --mode=644 --mtime=@0 --format=ustar -cf "$OLDPWD/fuzz/corpus/$name.tar" -T ../names
        )
        say "$name: $(tar -tf "fuzz/corpus/$name.tar" | wc -l) inputs kept"
    done
}

[ $# -ge 1 ] || usage
what=$1
shift
case "$what" in
keep | [1-9]*) ;;
*) usage ;;
esac
# shellcheck disable=SC2086 # one word per reader
[ $# -ge 1 ] || set -- $all
build_readers
if [ "$what" = keep ]; then keep "$@"; else fuzz "$what" "$@"; fi
