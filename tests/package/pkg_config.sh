#!/bin/sh
# Compiles an installed example as a build without CMake does, and runs it.
# usage: pkg_config.sh PKG_CONFIG COMPILER DIRECTORY_OF_PC EXAMPLES FLAGS
set -eu
export PKG_CONFIG_PATH="$3"
program=$(mktemp)
trap 'rm -f "$program"' EXIT
# shellcheck disable=SC2046,SC2086 # flags are words of their own
"$2" $5 -Wall -Wextra -Werror -O2 "$4/thousand_worlds.cpp" $("$1" --cflags --libs atoll) -o "$program"
"$program"
