#!/bin/sh
# rcac.wasm from the core; Debian 12: apt-get install clang lld. The same compiler gives the same bytes.
set -eu
cd "$(dirname "$0")"
${CC:-clang} --target=wasm32 -std=c99 -nostdlib -ffreestanding -DRCAC_FREESTANDING -Os -ffp-contract=off \
  -I../src -Wl,--no-entry,--strip-all,-z,stack-size=16384 rcac_wasm.c ../src/rcac.c -o rcac.wasm
