#!/usr/bin/env bash
# Builds Atoll and the drivers of other engines, runs one scene in each in turn, and prints the medians.
set -euo pipefail

root=$(dirname "$(dirname "$(realpath "${BASH_SOURCE[0]}")")")
# shellcheck source=runtime/setup.sh
source "$root/runtime/setup.sh"
packages+=("${view_packages[@]}" libgtest-dev libbenchmark-dev) # what a new build folder is configured with

usage() {
  cat <<'END'
usage: bash perf/compare.sh [--repeats N] [--steps N] [--seed N] SCENE [ATOLL OPTION...]

  --repeats N   runs of each engine (5)
  --steps N     steps of each run; the scene's own number where not given
  --seed N      seed of a scene with random content

Options after the scene go to `atoll run`, which gets --threads 2 where they name no other number.
END
}

repeats=5
common=()
while (($#)); do
  case $1 in
    --repeats) repeats=${2:?} && shift 2 ;;
    --steps | --seed) common+=("$1" "${2:?}") && shift 2 ;;
    -h | --help) usage && exit ;;
    *) break ;;
  esac
done
if (($# == 0)); then
  usage >&2
  exit 2
fi
scene=$1
shift
atoll_options=("$@")
[[ " $* " == *" --threads"* ]] || atoll_options+=(--threads 2)

# An engine that can't be installed is left out.
install_packages
for package in libbullet-dev libode-dev libmujoco-dev; do
  packages=("$package")
  install_packages || say "could not install $package; its engine is left out"
done
(cd "$root" && build release atoll_compare -DATOLL_BUILD_PEERS=ON)

results=$(mktemp -d)
trap 'rm -rf "$results"' EXIT
engines=(atoll)
for driver in "$root"/build/release/bin/atoll_peer_*; do
  [[ ! -x $driver ]] || engines+=("${driver##*_peer_}")
done

# The engines take turns, so that a machine that slows down slows all of them. One that can't simulate the scene has said
# why, and is left out from then on.
for ((i = 1; i <= repeats; ++i)); do
  able=()
  for engine in "${engines[@]}"; do
    say "$engine, run $i of $repeats"
    if [[ $engine == atoll ]]; then
      run=("$root/build/release/bin/atoll" run "$scene" "${atoll_options[@]}")
    else
      run=("$root/build/release/bin/atoll_peer_$engine" "$scene")
    fi
    if "${run[@]}" "${common[@]}" --format json >"$results/$engine.$i"; then
      able+=("$engine")
    elif [[ $engine == atoll ]]; then
      exit 1
    else
      say "$engine is left out"
    fi
  done
  engines=("${able[@]}")
done

# value FILE OBJECT KEY: a number of a JSON report; - where it has none.
value() {
  tr -d ' \n' <"$1" | awk -v object="\"$2\":{" -v key="\"$3\":" '{
    at = index($0, object)
    members = substr($0, at + length(object))
    members = substr(members, 1, index(members, "}"))
    found = at ? index(members, key) : 0
    print found ? substr(members, found + length(key)) + 0 : "-"
  }'
}

# median ENGINE OBJECT KEY, over the runs.
median() {
  local i
  for ((i = 1; i <= repeats; ++i)); do value "$results/$1.$i" "$2" "$3"; done |
    sort -g | awk '{ v[NR] = $1 } END { print v[int((NR + 1) / 2)] }'
}

printf '%-10s %11s %11s %8s %14s %13s %10s %10s\n' "$scene" 'mean ms' 'median ms' 'speed' \
  'penetration mm' 'max mm' 'sink mm' 'max mm'
reference=$(median "${engines[-1]}" ms_per_step mean)
for engine in "${engines[@]}"; do
  printf '%s\n' "$engine" "$(median "$engine" ms_per_step mean)" "$(median "$engine" ms_per_step median)" \
    "$(median "$engine" errors penetration_mean)" "$(median "$engine" errors penetration_max)" \
    "$(median "$engine" errors sink_mean)" "$(median "$engine" errors sink_max)"
done | awk -v reference="$reference" '
  function mm(metres) { return metres == "-" ? "-" : sprintf("%.3f", 1000 * metres) }
  { row[NR % 7] = $0 }
  NR % 7 == 0 {
    printf "%-10s %11.3f %11.3f %7.2fx %14s %13s %10s %10s\n",
      row[1], row[2], row[3], reference / row[2], mm(row[4]), mm(row[5]), mm(row[6]), mm(row[0])
  }'
