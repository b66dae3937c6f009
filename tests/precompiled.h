#pragma once

/// Includes of most tests, compiled once for all labels. A test names what it uses all the same.

#include <atoll/atoll.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>
