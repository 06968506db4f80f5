#!/usr/bin/env bash
# Installs what building and testing vcd needs on Debian 12, unless it is all there already. Needs root or sudo.
set -euo pipefail

packages=(
  g++ cmake ninja-build pkg-config
  libembree-dev libtbb-dev libboost-dev libdraco-dev libmeshoptimizer-dev
  libzstd-dev libxxhash-dev libhwy-dev nlohmann-json3-dev libcli11-dev libgtest-dev
  libpugixml-dev
  libpng-dev libopenexr-dev libstb-dev python3-matplotlib chromium chromium-driver python3-selenium
  zstd python3 mandoc slurm-wlm munge clang libclang-rt-14-dev llvm
)
missing=()
for package in "${packages[@]}"; do
  dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || missing+=("$package")
done
[ ${#missing[@]} -eq 0 ] && exit 0

echo "installing: ${missing[*]}" >&2
as_root=()
[ "$(id -u)" -eq 0 ] || as_root=(sudo)
export DEBIAN_FRONTEND=noninteractive
"${as_root[@]}" apt-get update -qq
"${as_root[@]}" apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
