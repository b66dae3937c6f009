#!/bin/bash
# Adds a member to each store of a world and compiles what tells a world's state: it must not compile, as nobody has
# said whether the member is state. Usage: forgotten_member.sh SCRATCH_DIRECTORY COMPILER FLAGS...
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
scratch=$1
shift
rm -rf "$scratch"
stores=(Stores StepClock BodyTable BodyRecords Sleeping ContactEvents SensorEvents ContactChoices
        QuarantineList JointTable SolverSelection BodyAabbs MotionBounds Broadphase ContactCache)
headers=(runtime/world/stores.h runtime/world/stores.h solver/include/solver/integrate/body_table.h
         runtime/world/body_records.h runtime/world/sleeping.h runtime/world/contact_events.h
         runtime/world/contact_events.h runtime/world/contact_choices.h
         runtime/world/quarantine.h runtime/world/joint_table.h solver/include/solver/select/solver_selection.h
         collision/include/collision/contacts/body_aabbs.h collision/include/collision/shapes/motion_bounds.h
         collision/include/collision/broadphase/broadphase.h collision/include/collision/contacts/contact_cache.h)
for i in "${!stores[@]}"; do
  header=${headers[i]}
  copy=$scratch/include/$(sed -E 's#^(runtime|solver/include|collision/include)/##' <<< "$header")
  mkdir -p "$(dirname "$copy")"
  [[ -e $copy ]] || cp "$root/$header" "$copy"
  sed -i -E "/^(struct|class) ${stores[i]} \{/a int forgotten = 0;" "$copy"
done
cat > "$scratch/probe.cpp" <<'CPP'
#include "state/world_state.h"
void probe(atl::StateHash& hash, const atl::Stores& world) { atl::WorldState(hash, world).visit(); }
CPP
compile() { "$1" -std=c++20 -fsyntax-only -fmax-errors=0 "${@:2}" "$scratch/probe.cpp"; }
compile "$@" || { echo "the state doesn't compile even without a new member"; exit 1; }
if compile "$1" -I"$scratch/include" "${@:2}" 2> "$scratch/errors"; then
  echo "stores have members that the state doesn't name, and it compiles"
  exit 1
fi
for store in "${stores[@]}"; do
  grep -Eq "\b$store\b.* decomposes into" "$scratch/errors" ||
    { echo "a new member of $store goes unnoticed:"; cat "$scratch/errors"; exit 1; }
done
echo "a new member is noticed in: ${stores[*]}"
