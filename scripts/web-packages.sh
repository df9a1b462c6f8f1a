#!/usr/bin/env bash
# Debian's packages that `cargo xtask web` builds and tests with: a Rust compiler with the source of its own
# standard library, from which cargo builds that for WebAssembly, and a browser.
set -euo pipefail
packages=(rustc-web cargo-web rust-web-src rust-web-llvm lld-22)
command -v chromium >/dev/null || packages+=(chromium)
run=()
[ "$(id -u)" = 0 ] || run=(sudo)
if ! "${run[@]}" apt-get install --yes --quiet --no-install-recommends "${packages[@]}"; then
    "${run[@]}" apt-get update --quiet
    "${run[@]}" apt-get install --yes --quiet --no-install-recommends "${packages[@]}"
fi
