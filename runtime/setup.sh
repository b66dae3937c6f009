# shellcheck shell=bash
# What runtime/run.sh and tests/run.sh share: the packages that a build needs, and the build.

# Debian's names; tests/run.sh adds those of tests.
packages=(cmake ninja-build g++ libc6-dev libeigen3-dev libtbb-dev libccd-dev libfcl-dev libhwy-dev libqhull-dev libcli11-dev
          nlohmann-json3-dev zlib1g-dev libpng-dev libtinygltf-dev)
# For `atoll view`: files for ParaView take HDF5, which is 17 packages, and the page that plays runs takes npm, which is
# several hundred of Debian's, so any other npm does. runtime/run.sh builds what there is for.
view_packages=(libhdf5-dev)
command -v npm >/dev/null || view_packages+=(npm)

say() {
  printf 'atoll: %s\n' "$*" >&2
}

# Installs the packages that are missing. A machine that has them all needs neither network nor root. One
# where they can't be installed is told what to install, and may go on: cmake stops at what it doesn't find.
install_packages() {
  if ! command -v apt-get >/dev/null; then
    say "no apt-get here; the build needs what Debian calls ${packages[*]}"
    return
  fi

  local package missing=()
  for package in "${packages[@]}"; do
    [[ "$(dpkg-query --show --showformat='${db:Status-Status}' "$package" 2>/dev/null)" == installed ]] ||
      missing+=("$package")
  done
  ((${#missing[@]})) || return 0

  local apt=(env DEBIAN_FRONTEND=noninteractive apt-get --quiet --yes)
  if ((EUID != 0)); then
    if ! command -v sudo >/dev/null; then
      say "as root, run: apt-get install ${missing[*]}"
      return
    fi
    apt=(sudo "${apt[@]}")
  fi
  say "installing ${missing[*]}"
  local install=("${apt[@]}" install --no-install-recommends "${missing[@]}")
  # The index is fetched where it doesn't know a package, or is too old for the mirror.
  if ! "${install[@]}" --simulate >/dev/null 2>&1 || ! "${install[@]}" >&2; then
    "${apt[@]}" update >&2
    "${install[@]}" >&2
  fi
}

# s of one core that a unit takes to compile, about: the mean over all, with GCC 12 on a machine of 2023.
readonly seconds_a_unit=4

# Whether the build folder of a preset is there, with options that somebody may have chosen.
is_configured() {
  [[ -f $root/build/$1/CMakeCache.txt ]]
}

# build PRESET TARGET [CMAKE OPTION]...
build() {
  local preset=$1 target=$2
  shift 2
  if ! command -v cmake >/dev/null; then
    say 'cmake was not found'
    return 1
  fi
  cd "$root"
  # A folder of another generator can't be gone on with.
  local fresh=()
  if is_configured "$preset" && ! grep -q '^CMAKE_GENERATOR:INTERNAL=Ninja$' "build/$preset/CMakeCache.txt"; then
    fresh=(--fresh)
  fi
  cmake --preset "$preset" "${fresh[@]}" "$@" >&2

  local object cores units=0
  cores=$(nproc)
  while read -r object; do
    [[ -f build/$preset/$object ]] || units=$((units + 1))
  done < <(ninja -C "build/$preset" -t commands "$target" | sed -nE 's/.* -o ([^ ]+\.(o|gch)) .*/\1/p')
  if ((units > 3)); then
    say "compiling $units units for $target ($preset), about $(((units * seconds_a_unit / cores + 59) / 60)) min on $cores cores"
  fi
  NINJA_STATUS='[%p, %es] ' cmake --build --preset "$preset" --target "$target" --parallel "$cores" >&2
}
