#!/usr/bin/env bash
# Builds Atoll and the drivers of other engines, and draws error against run time for all scenes with a closed form,
# for the large ones and for joints; the full sweep also how far each engine gets where scenes grow stiffer.
set -euo pipefail

root=$(dirname "$(dirname "$(realpath "${BASH_SOURCE[0]}")")")
# shellcheck source=runtime/setup.sh
source "$root/runtime/setup.sh"
packages+=("${view_packages[@]}" libgtest-dev libbenchmark-dev) # what a new build folder is configured with

usage() {
  cat <<'END'
usage: bash perf/sweep.sh [--quick] [--out DIR] [ATOLL SWEEP OPTION...]

  --quick    a coarse grid, about 3 minutes on two quiet cores; the full one takes about 20
  --out DIR  directory for index.html, results.json and results.csv (out/sweep)

Other options, as --threads 1,2,4, go to `atoll sweep`.
END
}

out=$root/out/sweep
options=()
while (($#)); do
  case $1 in
    --out) out=${2:?--out needs a directory} && shift 2 ;;
    -h | --help) usage && exit ;;
    *) options+=("$1") && shift ;;
  esac
done

install_packages
# Other engines are welcome, not needed: one that can't be installed is left out.
for package in libbullet-dev libode-dev libmujoco-dev; do
  (packages=("$package") && install_packages) || say "$package can't be installed; goes on without it"
done
cd "$root"
build release atoll_compare -DATOLL_BUILD_PEERS=ON

for driver in build/release/bin/atoll_peer_*; do
  if [[ -x $driver ]]; then options+=(--peer "$root/$driver"); fi
done
if [[ " ${options[*]} " != *" --quick "* ]]; then options+=(--frontier); fi
build/release/bin/atoll sweep --analytic pyramid3d wall islands pile hopper marbles stack:height=50 \
  chain:links=100,ratio=1000 joint-grid "${options[@]}" --out "$out"
