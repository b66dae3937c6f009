#!/usr/bin/env bash
# Builds Atoll once with everything and once without each capability, and prints what a capability costs a scene that
# doesn't use it, and one that does.
set -euo pipefail

root=$(dirname "$(dirname "$(realpath "${BASH_SOURCE[0]}")")")
# shellcheck source=runtime/setup.sh
source "$root/runtime/setup.sh"
packages+=("${view_packages[@]}" libgtest-dev libbenchmark-dev) # what a new build folder is configured with

usage() {
  cat <<'END'
usage: bash perf/features.sh [--steps N] [FEATURE...]

  --steps N   steps that are counted, after 30 to warm up (60)

Features are those of runtime/package/features.cmake, in lower case; all of them where none is named. Counting
instructions needs Debian's valgrind. Exit status 1 says that a state differs, or that a scene which doesn't use a
capability executes 0.5% more instructions with it than without.
END
}

steps=60
features=()
while (($#)); do
  case $1 in
    --steps) steps=${2:?--steps needs a number} && shift 2 ;;
    -h | --help) usage && exit ;;
    -*) usage >&2 && exit 2 ;;
    *) features+=("$1") && shift ;;
  esac
done
mapfile -t all_features < <(sed -n 's/^atoll_feature(\([A-Z_]*\) .*/\L\1/p' "$root/runtime/package/features.cmake")
if ((${#features[@]} == 0)); then features=("${all_features[@]}"); fi
everything=()
for feature in "${all_features[@]}"; do everything+=("-DATOLL_WITH_${feature^^}=ON"); done

packages+=(valgrind binutils)
install_packages
cd "$root"
results=$(mktemp -d)
trap 'rm -rf "$results"' EXIT

# program NAME [OPTION...]: builds the driver, and leaves it where it says. All are built in one folder, as only what asks
# for a capability is compiled again.
program() {
  local name=$1
  shift
  cmake -S . -B build/features -DCMAKE_BUILD_TYPE=Release -DATOLL_BUILD_TESTS=OFF -DATOLL_BUILD_COMMAND=OFF \
    -DATOLL_BUILD_PERF=ON "${everything[@]}" "$@" >/dev/null
  nice -n 5 cmake --build build/features --target atoll_feature_cost --parallel "$(nproc)" >&2
  cp build/features/bin/atoll_feature_cost "$results/$name"
  echo "$results/$name"
}

# bytes PROGRAM: of it, stripped.
bytes() {
  strip -o "$results/stripped" "$1"
  stat --format=%s "$results/stripped"
}

# measure PROGRAM SCENE: hash, median ms, allocations, and the instructions of all steps.
measure() {
  local line
  line=$("$1" "$2" "$steps")
  valgrind --tool=callgrind --callgrind-out-file="$results/callgrind" --toggle-collect='atl::World::step(double)' \
    "$1" "$2" "$steps" >/dev/null 2>&1
  echo "$line $(sed -n 's/^\(summary\|totals\): \([0-9]*\).*/\2/p' "$results/callgrind" | head -n 1)"
}

say "building everything"
whole=$(program all)
whole_bytes=$(bytes "$whole")
read -r whole_hash _ whole_allocations whole_count < <(measure "$whole" plain)

failed=0
printf '%-16s %10s %10s %6s %16s %16s %8s %16s %10s\n' feature 'bytes A' 'A - B' hash 'instructions A' \
  'instructions B' 'B/A - 1' 'instructions C' 'C/B'
for feature in "${features[@]}"; do
  option=ATOLL_WITH_${feature^^}
  say "building without $feature"
  options=("-D$option=OFF")
  if [[ $feature == snapshots ]]; then options+=(-DATOLL_WITH_RECORDING=OFF); fi
  without=$(program "$feature" "${options[@]}")
  read -r hash _ _ count < <(measure "$without" plain)
  read -r _ _ _ used_count < <(measure "$whole" "$feature")
  same=same
  if [[ $hash != "$whole_hash" ]]; then same=DIFFERS failed=1; fi
  size=$(bytes "$without")
  printf '%-16s %10d %10d %6s %16d %16d %7s%% %16d %10s\n' "$feature" "$size" \
    $((size - whole_bytes)) "$same" "$count" "$whole_count" \
    "$(awk -v a="$count" -v b="$whole_count" 'BEGIN { printf "%.3f", 100 * (b / a - 1) }')" "$used_count" \
    "$(awk -v b="$whole_count" -v c="$used_count" 'BEGIN { printf "%.3f", c / b }')"
  if ! awk -v a="$count" -v b="$whole_count" 'BEGIN { exit !(b <= 1.005 * a) }'; then failed=1; fi
done
say "everything: $whole_bytes bytes, state $whole_hash, $whole_allocations allocations in $steps steps"
exit "$failed"
