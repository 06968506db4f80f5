#!/usr/bin/env bash
# Installs the packages of a folder and tries each: for a bare root of Debian 12, as root. Ends with an error if one fails.
#
#   try_packages.sh FOLDER SOURCES      SOURCES: the project, for a mesh and a program in C
set -euo pipefail
packages=$(realpath "$1")
sources=$(realpath "$2")
export DEBIAN_FRONTEND=noninteractive
apt-get update -qq
apt-get install -y -qq --no-install-recommends "$packages"/*.deb g++ pkg-config man-db >/dev/null
cd "$(mktemp -d)"

echo "== vcd"
vc-bake "$sources/assets/shrub.glb" -o . --depth 3 --method proven --quiet
vc-info ./*.vcd | head -n 3
vc-info ./*.vcd --page page.html --picture classes.png
vc-verify ./*.vcd --against "$sources/assets/shrub.glb"
man --where vc-bake

echo "== libvcd-dev, libvcd0"
cc "$sources/tests/install/consumer/main.c" -o shared $(pkg-config --cflags --libs vcd)
./shared ./shrub*.vcd
ldd shared | grep libvcd
cc "$sources/tests/install/consumer/main.c" -o static $(pkg-config --cflags --libs vcd-static)
./static ./shrub*.vcd

echo "== libvcd-baker-dev"
c++ -std=c++20 "$sources/examples/export_sidecar.cpp" -o export_sidecar $(pkg-config --cflags --libs vcd-baker)
./export_sidecar pyramid.vcd 2>/dev/null
vc-verify pyramid.vcd

echo "== python3-vcd"
python3 -c 'import vcd, glob; print(vcd.__file__, vcd.open(glob.glob("*.vcd")[0]))'

echo "== vcd-embree3"
said=$(LD_PRELOAD=libvcd_embree3.so /bin/true 2>&1)  # the loader goes on without a library that is missing
[[ -z $said ]] || { echo "$said" && exit 1; }
ldd /usr/lib/*/libvcd_embree3.so | grep 'libembree3.so.*=> /'

echo "== removed again"
apt-get purge -y -qq vcd libvcd0 libvcd-dev libvcd-baker-dev python3-vcd vcd-embree3 >/dev/null
left=$(find /usr -name '*vcd*' -not -path '*/doc/*' -not -path '/usr/share/mime/*')  # there, vcd is video
[[ -z $left ]] || { echo "$left" && exit 1; }
