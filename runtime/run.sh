#!/usr/bin/env bash
# Builds the atoll command, first installing what the build needs, and runs it with the arguments given.
# Without any it simulates a pile of 5000 boxes.
set -euo pipefail

root=$(dirname "$(dirname "$(realpath "${BASH_SOURCE[0]}")")")
# shellcheck source=runtime/setup.sh
source "$root/runtime/setup.sh"

(($#)) || set -- run pile
install_packages
options=()
is_configured release ||
  options=(-DATOLL_BUILD_TESTS=OFF -DATOLL_BUILD_PERF=OFF -DATOLL_BUILD_PAGE=AUTO -DATOLL_BUILD_VTK=AUTO)
build release atoll_command "${options[@]}"
exec "$root/build/release/bin/atoll" "$@"
