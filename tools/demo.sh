#!/usr/bin/env bash
# The whole path once: installs what building needs, builds (build/demo), bakes the bundled shrub, renders its shadow with
# and without the sidecar (build/shrub.bmp), verifies the sidecar and shows what it holds.
set -euo pipefail
cd "$(dirname "$0")/.."

tools/install_dependencies.sh build
echo "building (build/demo) ..." >&2
cmake -S . -B build/demo -G Ninja >/dev/null
build() { cmake --build build/demo --target "$@" >/dev/null; }
bin=build/demo/bin
sidecar=build/shrub.vcd
run() { echo; echo "\$ $*"; "$@"; }
build vc-bake shadow-picture
run $bin/vc-bake assets/shrub.glb -o $sidecar
run $bin/shadow-picture assets/shrub.glb $sidecar build/shrub.bmp
build vc-verify vc-info
run $bin/vc-verify $sidecar --against assets/shrub.glb --lines 200000 --keep 3
run $bin/vc-info $sidecar
