#!/usr/bin/env bash
# The whole path once: installs what is missing, builds, bakes the bundled shrub, verifies the sidecar, shows what it
# holds, and casts shadow rays with and without it.
set -euo pipefail
cd "$(dirname "$0")/.."

tools/install_dependencies.sh
echo "building (build/release) ..." >&2
cmake --preset release >/dev/null
cmake --build --preset release --target vc-bake vc-verify vc-info vc-bench >/dev/null

bin=build/release/bin
sidecar=build/shrub.vcd
run() { echo; echo "\$ $*"; "$@"; }
run $bin/vc-bake assets/shrub.glb -o $sidecar
run $bin/vc-verify $sidecar --against assets/shrub.glb --lines 200000 --keep 3
run $bin/vc-info $sidecar
run $bin/vc-bench segments $sidecar assets/shrub.glb
