#!/usr/bin/env bash
# Cross-compiles the determinism tests for 64-bit ARM and holds what they come to, emulated, to the golden hashes, on
# NEON and portable. Takes half an hour. An argument, if there is one, is the tests to run, for --gtest_filter.
# Needs Debian: its arm64 libraries are fetched beside the build, and nothing of the system is changed but for the
# compiler and the emulator, which are installed.
set -euo pipefail

here=$(dirname "$(realpath "${BASH_SOURCE[0]}")")
root=$(dirname "$(dirname "$here")")
# shellcheck source=runtime/setup.sh
source "$root/runtime/setup.sh"

packages+=(g++-aarch64-linux-gnu qemu-user ninja-build)
install_packages

build=$root/build/aarch64
sysroot=$build/sysroot
if [[ ! -d $sysroot ]]; then
  say 'fetching libraries for arm64'
  mkdir -p "$build"/apt/{lists,cache/archives}/partial
  : >"$build/apt/status"
  apt=(apt-get --quiet -o APT::Architecture=arm64 -o APT::Architectures=arm64 -o Dir::State="$build/apt"
       -o Dir::State::Lists="$build/apt/lists" -o Dir::State::status="$build/apt/status" -o Dir::Cache="$build/apt/cache")
  "${apt[@]}" update >&2
  "${apt[@]}" --yes --no-install-recommends --download-only install libhwy-dev libtbb-dev libfcl-dev libccd-dev \
    libqhull-dev libgtest-dev nlohmann-json3-dev libeigen3-dev >&2
  for package in "$build"/apt/cache/archives/*.deb; do dpkg -x "$package" "$sysroot.part"; done
  # It names the C library's by where that would be on the machine itself.
  sed -i 's|/usr/lib/aarch64-linux-gnu/libm.so|m|' "$sysroot.part"/usr/lib/aarch64-linux-gnu/ccd/ccd-targets-none.cmake
  mv "$sysroot.part" "$sysroot"
fi

say 'building for arm64'
cmake -S "$root" -B "$build/cmake" -G Ninja -DCMAKE_BUILD_TYPE=Release -DATOLL_BUILD_PERF=OFF -DATOLL_BUILD_COMMAND=OFF \
  -DCMAKE_TOOLCHAIN_FILE="$here/toolchain.cmake" -DATOLL_AARCH64_ROOT="$sysroot" >&2
cmake --build "$build/cmake" --target atoll_test_determinism --parallel "$(nproc)" >&2
qemu-aarch64 -L "$sysroot" "$build/cmake/bin/atoll_test_determinism" --gtest_filter="${1:-*Golden*}"
