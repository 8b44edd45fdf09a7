#!/bin/sh
# Sets this machine up, builds, and renders a picture or runs the tests.
# See the usage text below. Needs cargo and rustc; installs the rest on Debian and Ubuntu.
set -eu

usage() {
    cat <<'TEXT'
usage: ./whitted.sh render   build, then render scenes/cornell.toml to cornell.png
       ./whitted.sh test     build, then run all tests
       ./whitted.sh devices-test
                             build, then test on every driver that can be had without hardware: lavapipe of
                             the system, SwiftShader of Chromium, lavapipe of Debian 13 in a folder of its own
       ./whitted.sh setup    only set up: `cargo build` then compiles the kernels of glsl/ with shaderc
       ./whitted.sh kernels  compile the kernels, and renew glsl/kernels.pack
       ./whitted.sh fuzz     build the readers for libFuzzer, and run it over them for a minute
       ./whitted.sh corpus-test
                             load some thousand models of published packages, which it fetches, and compare them with
                             trimesh, pictures of some with Embree (needs python3 with venv, npm, pip)
       ./whitted.sh farm-test  build, then run the templates of farm/ on Open Job Description, Slurm and GNU parallel

On Debian and Ubuntu missing packages are installed by apt-get, with sudo if need be. Elsewhere the
script says what is missing. Nothing is downloaded where nothing is missing.

devices-test makes the Debian 13 with debootstrap, as root, in $WHITTED_DEBIAN_13 or, unless that is set,
in the user's cache folder (800 MB, kept for the next time). Where it cannot, it says so and tests the rest.
TEXT
}

say() { printf '%s\n' "whitted: $*" >&2; }
fail() { say "$*"; exit 1; }
have() { command -v "$1" >/dev/null 2>&1; }
# True if a file matches the pattern, which the caller leaves unquoted.
any() { [ -e "$1" ]; }

need_rust() {
    # rustup puts cargo where only a login shell looks.
    have cargo || PATH="${CARGO_HOME:-$HOME/.cargo}/bin:$PATH"
    have cargo && have rustc ||
        fail "cargo and rustc are missing: install Rust 1.88 or newer, for instance from https://rustup.rs"
}

# A Vulkan driver's manifest, in the folders that the loader searches. With "cpu" only lavapipe's counts.
have_driver() {
    if [ "${1:-}" != cpu ] && [ -n "${VK_DRIVER_FILES:-}${VK_ICD_FILENAMES:-}" ]; then return 0; fi
    for folder in /usr/share/vulkan/icd.d /usr/local/share/vulkan/icd.d /etc/vulkan/icd.d; do
        if [ "${1:-}" = cpu ]; then
            any "$folder"/lvp_icd*.json && return 0
        else
            any "$folder"/*.json && return 0
        fi
    done
    return 1
}

have_loader() {
    for folder in "/usr/lib/$machine-linux-gnu" /usr/lib64 /usr/lib /usr/local/lib ${VULKAN_SDK:+"$VULKAN_SDK/lib"}; do
        any "$folder"/libvulkan.so.1* && return 0
    done
    return 1
}

have_layer() {
    for folder in /usr/share/vulkan /usr/local/share/vulkan /etc/vulkan ${VULKAN_SDK:+"$VULKAN_SDK/share/vulkan"}; do
        any "$folder"/explicit_layer.d/VkLayer_khronos_validation.json && return 0
    done
    return 1
}

# The crate `shaderc` links libshaderc. Debian's shared library lacks symbols and its static one holds
# only a part, so try to link against the shared one instead of guessing by the system's name.
have_sound_shaderc() {
    have cc || return 1
    scratch=$(mktemp -d)
    printf '%s\n' 'void *shaderc_compiler_initialize(void);' \
        'int main(void) { return shaderc_compiler_initialize() == 0; }' >"$scratch/probe.c"
    status=1
    for name in shaderc shaderc_shared; do
        cc "$scratch/probe.c" -o "$scratch/probe" "-l$name" >/dev/null 2>&1 && status=0
    done
    rm -rf "$scratch"
    return $status
}

shaderc_is_chosen() { [ -n "${SHADERC_LIB_DIR:-}${VULKAN_SDK:-}" ]; }

# One package per missing thing, in words of Debian.
missing_packages() {
    have cc || echo gcc libc6-dev
    [ -e /etc/ssl/certs/ca-certificates.crt ] || [ -n "${SSL_CERT_FILE:-}" ] || echo ca-certificates # for cargo
    # Without shaderc the build takes the kernels of glsl/kernels.pack, so elsewhere it need not be there.
    if have apt-get; then
        have c++ || echo g++ # shaderc needs its standard library
        if ! shaderc_is_chosen && ! any "$merged" && ! have_sound_shaderc; then
            have ar || echo binutils
            [ -e "$libraries/libshaderc_combined.a" ] || echo libshaderc-dev
            [ -e "$libraries/libglslang.a" ] || echo glslang-dev
            [ -e "$libraries/libSPIRV-Tools.a" ] || echo spirv-tools
        fi
        have spirv-opt || echo spirv-tools
    fi
    have_loader || echo libvulkan1
    if [ "$1" != render ]; then
        have_driver cpu || echo mesa-vulkan-drivers
        have_layer || echo vulkan-validationlayers
        have chromium || echo chromium # opens the pages that the tests write, and brings SwiftShader
        # For the Debian 13 of devices-test; the script says what is missing where it is no package.
        if [ "$1" = devices-test ] && [ "$(id -u)" = 0 ]; then have debootstrap || echo debootstrap; fi
    else
        have_driver || echo mesa-vulkan-drivers
    fi
}

install_packages() {
    say "installing $*"
    root=
    if [ "$(id -u)" != 0 ]; then
        have sudo || fail "sudo is missing: run as root \`apt-get install $*\`, then this again"
        root='sudo'
    fi
    # A broken third-party source is no reason to stop: apt-get install has the last word.
    $root env DEBIAN_FRONTEND=noninteractive apt-get update -q >&2 </dev/null || say "apt-get update failed; trying all the same"
    $root env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends "$@" >&2 </dev/null ||
        fail "apt-get could not install $*"
}

need_packages() {
    # shellcheck disable=SC2046 # one word per package
    set -- $(missing_packages "$1")
    [ $# -gt 0 ] || return 0
    if have apt-get; then
        install_packages "$@"
    else
        fail "missing here; on Debian the packages are called: $*
Install a C and C++ compiler, a Vulkan loader, a Vulkan driver (Mesa's lavapipe will do) and, for the tests,
lavapipe, the Khronos validation layer and Chromium; to change kernels also libshaderc (or the Vulkan SDK)
and spirv-opt."
    fi
}

# Joins what Debian splits into one archive, and tells cargo where it is. The member libraries differ
# between releases; the ones that exist are the ones that are needed.
merge_shaderc() {
    mkdir -p "$(dirname "$merged")"
    script=$(
        echo "create $merged.new"
        for name in shaderc_combined glslang MachineIndependent GenericCodeGen OSDependent OGLCompiler HLSL SPIRV \
            glslang-default-resource-limits SPIRV-Tools-opt SPIRV-Tools; do
            [ ! -e "$libraries/lib$name.a" ] || echo "addlib $libraries/lib$name.a"
        done
        echo save
        echo end
    )
    printf '%s\n' "$script" | ar -M || fail "ar could not merge the archives of libshaderc"
    mv "$merged.new" "$merged"
}

# Adds to cargo's configuration: $1 a word of the setting, $2 its table, $3 the setting.
configure() {
    config=.cargo/config.toml
    mkdir -p .cargo
    if [ -e $config ]; then
        if grep -qF "$1" $config; then return 0; fi
        if grep -qF "$2" $config; then fail "add to $2 of $config: $3"; fi
    fi
    printf '%s\n' "$2" "$3" >>$config
}

# Lets cargo link shaderc where it can be linked. Elsewhere the build takes the kernels of glsl/kernels.pack.
prepare_shaderc() {
    if ! shaderc_is_chosen && ! any "$merged" && ! have_sound_shaderc; then
        if ! [ -e "$libraries/libshaderc_combined.a" ]; then
            say 'no libshaderc: the kernels are those of glsl/kernels.pack'
            return 0
        fi
        merge_shaderc
    fi
    if any "$merged"; then
        configure SHADERC_LIB_DIR '[env]' 'SHADERC_LIB_DIR = { value = ".cargo/shaderc", relative = true }'
    fi
    configure whitted_shaderc "[target.'cfg(all())']" 'rustflags = ["--cfg", "whitted_shaderc"]'
}

# Makes a Debian 13 for its Mesa 25, once. Sets $debian to its folder; empty if there is none.
need_debian_13() {
    debian=${WHITTED_DEBIAN_13:-${XDG_CACHE_HOME:-$HOME/.cache}/whitted/debian-13}
    if any "$debian"/usr/share/vulkan/icd.d/lvp_icd*.json && any "$debian"/usr/share/vulkan/explicit_layer.d/*validation*.json; then
        [ "$(id -u)" != 0 ] || return 0
        without='only root may enter it'
    elif [ "$(id -u)" != 0 ]; then
        without='only root may make it'
    elif ! have debootstrap; then
        without='debootstrap is missing'
    elif rm -rf "$debian.new" && mkdir -p "$debian.new" && debootstrap --variant=minbase \
        --include=libvulkan1,mesa-vulkan-drivers,vulkan-validationlayers trixie "$debian.new" >"$debian.log" 2>&1 </dev/null; then
        rm -rf "$debian.new/var/cache/apt/archives" "$debian"
        mv "$debian.new" "$debian"
        return 0
    else
        without="debootstrap failed, as without a network ($debian.log)"
    fi
    say "NOT TESTED: Mesa 25 of Debian 13: $without"
    debian=
}

test_devices() {
    need_debian_13
    if [ -n "$debian" ]; then
        WHITTED_DEBIAN_13=$debian cargo test --locked --test device_lane -- --ignored </dev/null
    else
        cargo test --locked --test device_lane -- --ignored --skip mesa_25 </dev/null
    fi
}

setup() {
    machine=$(uname -m)
    libraries=/usr/lib/$machine-linux-gnu
    merged=.cargo/shaderc/libshaderc_combined.a
    need_rust
    need_packages "$1"
    prepare_shaderc
}

main() {
    case "${1:-}" in
    render | test | devices-test | setup | kernels | fuzz | corpus-test | farm-test) [ $# -eq 1 ] || { usage >&2; exit 2; } ;;
    -h | --help | help) usage; exit 0 ;;
    *) usage >&2; exit 2 ;;
    esac
    unset CDPATH
    cd "$(dirname "$0")"
    setup "$1"
    case "$1" in
    render)
        cargo run --release --locked -- render scenes/cornell.toml -o cornell.png </dev/null
        say "the picture is $PWD/cornell.png"
        ;;
    test) cargo test --locked --no-fail-fast </dev/null ;;
    devices-test) test_devices ;;
    fuzz) sh fuzz/run.sh 60 </dev/null ;;
    corpus-test) python3 tests/corpus/corpus.py --formats gltf,ply,stl,obj </dev/null ;;
    farm-test)
        cargo build --release --locked </dev/null
        sh farm/test.sh </dev/null
        ;;
    setup) say "ready: cargo build and cargo test work" ;;
    kernels)
        WHITTED_UPDATE_KERNELS=1 cargo test --locked --test packed_kernels </dev/null
        say "glsl/kernels.pack holds the kernels of glsl" ;;
    esac
}

main "$@"
