#pragma once

#include <cstdint>

/// Calls of operator new in this program so far, those of containers among them. Linking this replaces the operators.
std::int64_t allocation_count();
