#pragma once

#include <nlohmann/json.hpp>

#include "results.h"

namespace atl::command {

/// The contents of results.json, which the page draws.
nlohmann::ordered_json results_object(const SweepResults& results);

}  // namespace atl::command
