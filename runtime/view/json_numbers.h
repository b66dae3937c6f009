#pragma once

#include <atoll/types.h>

#include <cmath>
#include <nlohmann/json.hpp>

namespace atl::view {

/// In the order in which members are set.
using Json = nlohmann::ordered_json;

/// JSON has no number that is not finite.
inline Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }
inline Json numbers(const Vector3& v) { return {number(v.x()), number(v.y()), number(v.z())}; }
inline Json numbers(const Quaternion& q) { return {q.x(), q.y(), q.z(), q.w()}; }  ///< unit

}  // namespace atl::view
