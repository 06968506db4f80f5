#!/usr/bin/env bash
# What the CI runs: installs what is missing, builds the presets release and asan (the one with assertions), and runs all
# tests of both. Sources are compiled several at a time, which takes a third of the time.
set -euo pipefail
cd "$(dirname "$0")/.."

tools/install_dependencies.sh test lab python
for preset in release asan; do
  echo "== $preset: build" >&2
  cmake --preset $preset -DCMAKE_UNITY_BUILD=ON >/dev/null
  cmake --build --preset $preset
  echo "== $preset: test" >&2
  ctest --preset $preset
done
