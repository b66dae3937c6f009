#pragma once

#include "checks/tradeoff/grid.h"
#include "checks/tradeoff/record.h"
#include "checks/tradeoff/stop.h"

namespace atl::tradeoff {

/// Empty. With `diagnostics` it keeps its contact problems. Throws SceneError on settings that this machine lacks.
World make_world(const ScenePlan& plan, const Configuration& configuration, bool diagnostics);

/// A record with the name and the coordinates of a configuration, and nothing measured yet.
Record describe(const ScenePlan& plan, const Configuration& configuration);

// Both throw Stopped between steps, and then leave no sample behind.

/// Simulates once, observed after every step, and fills in outcome, errors and hash. The errors are those of
/// atl::ErrorMeter, and the largest and the median contact residual over the steps.
void measure_errors(const ScenePlan& plan, const Configuration& configuration, Record& record, const Stop& stop);

/// Simulates in fresh worlds, diagnostics off, until at least `min_time` s were spent in steps and the forces before
/// them, and adds the time of that as one sample. Throws OtherBits unless it ends in the record's state, bit for bit.
void measure_time(const ScenePlan& plan, const Configuration& configuration, double min_time, Record& record,
                  const Stop& stop);

/// CPU time of this process, s.
double process_time();

}  // namespace atl::tradeoff
