#!/usr/bin/env bash
# Installs on Debian 12 what vcd needs and is not there yet. Needs root or sudo.
#
#   tools/install_dependencies.sh build          to build the libraries and programs, and to use them
#   tools/install_dependencies.sh test           to test them as well
#   tools/install_dependencies.sh lab            to build and use tools/lab, and to test it
#   tools/install_dependencies.sh python         to build and use the Python module, and to test it
#   tools/install_dependencies.sh packages       to make Debian packages
#   tools/install_dependencies.sh test lab python    all that CI uses
set -euo pipefail

build=(
  g++ cmake ninja-build pkg-config
  libembree-dev libtbb-dev libdraco-dev libmeshoptimizer-dev libopenmesh-dev libtinygltf-dev
  libzstd-dev libxxhash-dev libhwy-dev nlohmann-json3-dev libcli11-dev libpugixml-dev
  libjs-three libpng-dev libstb-dev zlib1g-dev
)
test=(
  libgtest-dev libboost-dev python3 zstd mandoc clang clang-format libclang-rt-14-dev llvm slurm-wlm munge abigail-tools
)
lab=(
  libopenexr-dev python3-matplotlib chromium chromium-driver python3-selenium
)
python=(
  python3-dev pybind11-dev python3-numpy
)
deb=(
  dpkg-dev file help2man
)

packages=("${build[@]}")
for list in "${@:-?}"; do
  case $list in
    build) ;;
    test) packages+=("${test[@]}") ;;
    lab) packages+=("${lab[@]}") ;;
    python) packages+=("${python[@]}") ;;
    packages) packages+=("${deb[@]}") ;;
    *) echo "usage: tools/install_dependencies.sh build|test|lab|python|packages ..." >&2; exit 1 ;;
  esac
done

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
