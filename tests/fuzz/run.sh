#!/usr/bin/env bash
# Runs the targets of this folder with libFuzzer, one after another, each so many minutes on one core and on past what it
# finds; then tells which lines of the library the inputs it keeps get to. Called by tests/run.sh --fuzz, which has
# built them.
set -euo pipefail

root=$(dirname "$(dirname "$(dirname "$(realpath "${BASH_SOURCE[0]}")")")")
minutes=$1
shift
targets=("$@")
((${#targets[@]})) || targets=(api batch geometry mechanism scene snapshot recording changes contacts direct
                               forces joints queries solids)

build=$root/build/fuzz
bin=$build/bin
corpus=$build/corpus
findings=$build/findings
mkdir -p "$corpus" "$findings"
"$bin/atoll_fuzz_seeds" "$corpus" "$root"/runtime/scene/examples/*.json

# What a file that says so may take is bounded; what takes longer than a minute, with the sanitizers, is a finding.
# The entropic schedule takes three quarters of the time of api to itself, as an input has so many features.
options=(-rss_limit_mb=3000 -malloc_limit_mb=2000 -timeout=60 -report_slow_units=60 -max_len=16384 -entropic=0)
export ATOLL_DYNAMIC_THREADS=0
status=0
for target in "${targets[@]}"; do
  echo "atoll: $target, $minutes min" >&2
  # A child process runs the inputs, and another one goes on where it has crashed.
  going_on=(-fork=1 -ignore_crashes=1 -ignore_timeouts=1 -ignore_ooms=1 -print_funcs=0)
  touch "$build/$target.start"
  LLVM_PROFILE_FILE=/dev/null "$bin/atoll_fuzz_$target" "${options[@]}" "${going_on[@]}" \
    -max_total_time=$((60 * minutes)) -artifact_prefix="$findings/$target-" \
    "$corpus/$target" >"$build/$target.log" 2>&1 || status=1
  { grep -E '^#[0-9]+: cov' "$build/$target.log" | tail -1 || true; } >&2
  while read -r finding; do
    status=1
    echo "atoll: found $finding" >&2
  done < <(find "$findings" -name "$target-*" -newer "$build/$target.start" | sort)
  LLVM_PROFILE_FILE=$build/$target.profraw "$bin/atoll_fuzz_$target" "${options[@]}" -runs=0 "$corpus/$target" \
    >>"$build/$target.log" 2>&1 || status=1
done

profiles=("${targets[@]/#/$build/}")
llvm-profdata-14 merge -sparse "${profiles[@]/%/.profraw}" -o "$build/coverage"
objects=()
for target in "${targets[@]}"; do objects+=(-object "$bin/atoll_fuzz_$target"); done
llvm-cov-14 report "${objects[@]:1}" -instr-profile="$build/coverage" \
  "$root"/runtime/state "$root"/runtime/scene "$root"/runtime/world |
  awk '/^Filename|^TOTAL|\.(cpp|h) / { print $1, $(NF - 3), $(NF - 5) }' | column -t
exit $status
