#!/usr/bin/env bash
# Cross-compiles for 64-bit ARM and holds what that comes to, emulated, with NEON and portable, to the golden hashes of
# all builds: the cases in differing.txt have to come to others, all else to the same. Of the
# layers' unit tests those in failing.txt fail, and no others.
# Needs Debian: its arm64 libraries are fetched beside the build, and nothing of the system is changed but for the
# compiler and the emulator, which are installed.
set -euo pipefail

here=$(dirname "$(realpath "${BASH_SOURCE[0]}")")
root=$(dirname "$(dirname "$here")")
# shellcheck source=runtime/setup.sh
source "$root/runtime/setup.sh"

build=$root/build/aarch64
sysroot=$build/sysroot

fetch_libraries() {
  say 'fetching libraries for arm64'
  mkdir -p "$build"/apt/{lists,cache/archives}/partial
  : >"$build/apt/status"
  local apt=(apt-get --quiet --yes -o APT::Architecture=arm64 -o APT::Architectures=arm64 -o Dir::State="$build/apt"
             -o Dir::State::Lists="$build/apt/lists" -o Dir::State::status="$build/apt/status"
             -o Dir::Cache="$build/apt/cache")
  "${apt[@]}" update >&2
  "${apt[@]}" --no-install-recommends --download-only install libhwy-dev libtbb-dev libfcl-dev libccd-dev \
    libqhull-dev libgtest-dev nlohmann-json3-dev libeigen3-dev >&2
  rm -rf "$sysroot.part"
  local package
  for package in "$build"/apt/cache/archives/*.deb; do dpkg -x "$package" "$sysroot.part"; done
  # It names the C library's by where that would be on the machine itself.
  sed -i 's|/usr/lib/aarch64-linux-gnu/libm.so|m|' "$sysroot.part"/usr/lib/aarch64-linux-gnu/ccd/ccd-targets-none.cmake
  mv "$sysroot.part" "$sysroot"
}

# A fused operation rounds once where x86-64, as it is built, rounds twice.
expect_no_fused_operations() {
  local archive
  for archive in "$build"/cmake/libatoll_{jobs,collision,solver,runtime}.a; do
    if aarch64-linux-gnu-objdump --disassemble "$archive" | grep -E '\sf(n?m(add|sub)|ml[as])\s' >&2; then
      say "found fused operations in $archive; expected none"
      return 1
    fi
  done
}

emulate() {
  qemu-aarch64 -L "$sysroot" "$build/cmake/bin/$1" "${@:2}"
}

# expect_failures PROGRAM LIST [GTEST OPTION]...: runs the tests; those in the list fail, and no others.
expect_failures() {
  local program=$1 list=$here/$2 log=$build/$1.log
  shift 2
  say "running $program"
  emulate "$program" "$@" >"$log" || true
  if ! grep -q '^\[==========\] .* ran\.' "$log"; then
    say "$program did not run to the end, see $log"
    return 1
  fi
  # Without numbers and parameters: "Cases/Golden.HashesAreThoseOfTheFile/7_defaults_wall, where ..." is defaults_wall.
  if ! diff --label "$list" --label found <(grep -v '^#' "$list" | sort) \
    <(sed -nE '/^\[  FAILED  \] .*\./{s|^\[  FAILED  \] ||; s/(,| \().*//; s|.*/[0-9]+_||; p}' "$log" | sort -u) >&2; then
    say "other tests of $program fail than those in $list, see $log"
    return 1
  fi
}

packages+=("${view_packages[@]}" g++-aarch64-linux-gnu qemu-user ninja-build)
install_packages
[[ -d $sysroot ]] || fetch_libraries
say 'building for arm64'
cmake -S "$root" -B "$build/cmake" -G Ninja -DCMAKE_BUILD_TYPE=Release -DATOLL_BUILD_PERF=OFF -DATOLL_BUILD_COMMAND=OFF \
  -DCMAKE_TOOLCHAIN_FILE="$here/toolchain.cmake" -DATOLL_AARCH64_ROOT="$sysroot" >&2
cmake --build "$build/cmake" --target atoll_aarch64_golden atoll_aarch64_unit --parallel "$(nproc)" >&2
expect_no_fused_operations
expect_failures atoll_aarch64_golden differing.txt --gtest_filter='Cases/Golden.*'
expect_failures atoll_aarch64_unit failing.txt
