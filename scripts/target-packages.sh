#!/usr/bin/env bash
# Debian's packages that `cargo xtask targets` builds and runs with: a Rust compiler with the source of its own standard
# library; for aarch64 a linker, a C library and an emulator; for WebAssembly a linker and a C library (node runs it).
# As root, or where sudo asks nothing. `target-packages.sh aarch64`, `target-packages.sh wasm`; without a word, both.
set -euo pipefail
[ $# -gt 0 ] || set -- aarch64 wasm
packages=(rustc-web cargo-web rust-web-src)
for target; do
    case $target in
        aarch64) packages+=(gcc-aarch64-linux-gnu libc6-dev-arm64-cross qemu-user) ;;
        wasm) packages+=(rust-web-llvm lld-22 wasi-libc) ;;
        *) echo "$target: allowed are aarch64 and wasm" >&2; exit 2 ;;
    esac
done
run=()
[ "$(id -u)" = 0 ] || run=(sudo --non-interactive)
# The newest of rustc-web is wanted, and the lists may be of the day when the machine was made.
"${run[@]}" apt-get update --quiet || echo "no new lists of packages" >&2
"${run[@]}" apt-get install --yes --quiet --no-install-recommends "${packages[@]}"
