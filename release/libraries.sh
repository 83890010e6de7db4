#!/usr/bin/env bash
# The FMU's library for other platforms, and for any Linux since 2014, from these sources: release/libraries.sh [PLATFORM ...]   (all when none is named)
#
# Needs rustup, and linkers: pip install ziglang cargo-zigbuild for Linux and macOS, mingw-w64 (Debian: gcc-mingw-w64-x86-64-win32) for Windows, where zig's would export every symbol. Writes target/libraries/PLATFORM/; each library is stripped, has no path of this machine in it and
# shows no symbols but FMI's (checked by tests/fmu/library.py where Python has pyelftools and pefile). Then
#   wheelrail export SCENE --library linux64=target/libraries/linux64/libwheelrail.so --library win64=target/libraries/win64/wheelrail.dll ...
# with a program that was built from the same sources (cargo build --release).
set -euo pipefail
cd "$(dirname "$0")/.."

# glibc 2.17 is what Linux machines since 2014 have; FMUs of other platforms need nothing like it.
declare -A targets=(
    [linux64]=x86_64-unknown-linux-gnu.2.17
    [aarch64-linux]=aarch64-unknown-linux-gnu.2.17
    [win64]=x86_64-pc-windows-gnu
    [darwin64]=x86_64-apple-darwin
    [aarch64-darwin]=aarch64-apple-darwin
)
[ $# -gt 0 ] || set -- linux64 aarch64-linux win64 darwin64 aarch64-darwin

# Sources of other crates, and these, under names that are the same everywhere.
cargo fetch --locked --quiet
remap="--remap-path-prefix=$PWD=wheelrail"
for folder in "${CARGO_HOME:-$HOME/.cargo}"/registry/src/*/; do
    remap="--remap-path-prefix=${folder%/}=crates $remap"
done
export RUSTFLAGS="$remap" CARGO_PROFILE_RELEASE_STRIP=symbols CARGO_TARGET_DIR="$PWD/target/cross"

for platform in "$@"; do
    target=${targets[$platform]:?"no such platform: $platform"}
    triple=${target%.2.17}
    rustup target add "$triple"
    if [ "$platform" = win64 ]; then
        CARGO_TARGET_X86_64_PC_WINDOWS_GNU_LINKER=x86_64-w64-mingw32-gcc cargo build --locked --release --lib --no-default-features --target "$target"
    else
        cargo zigbuild --locked --release --lib --no-default-features --target "$target"
    fi
    mkdir -p "target/libraries/$platform"
    for name in libwheelrail.so libwheelrail.dylib wheelrail.dll; do
        file="$CARGO_TARGET_DIR/$triple/release/$name"
        [ ! -f "$file" ] || cp "$file" "target/libraries/$platform/"
    done
    ls -l "target/libraries/$platform"
done
if python3 -c 'import elftools, pefile' 2>/dev/null; then
    for platform in "$@"; do
        python3 tests/fmu/library.py "target/libraries/$platform"/*wheelrail.* --release --glibc 2.17
    done
fi
