#pragma once
/// Which bodies are in sensors as a step ends, and what that changed.

#include <jobs/arena.h>

#include "world/stores.h"

namespace atl {

/// Keeps the poses with which a step begins, for continuous sensors.
void begin_sensing(Stores& world);
/// Asks the broadphase, once a sensor: bodies don't notice.
void record_sensor_events(Stores& world, jobs::Arena& arena);

}  // namespace atl
