#pragma once
/// A program of calls of the public API, chosen from bytes.

#include <cstdint>
#include <span>
#include <string>

#include "definitions.h"
#include "lockstep.h"

namespace atl::fuzz {

struct ProgramResult {
  int calls = 0;  ///< that were made, as far as the bytes go
  int steps = 0;
  int refused = 0;         ///< calls that threw Error
  int quarantined = 0;     ///< bodies that steps took out
  std::uint64_t hash = 0;  ///< of the state at the end
};

struct ProgramLimits {
  int calls = 1 << 30;
  int steps = 32;
  std::size_t bodies = 16;
  std::size_t joints = 16;
  bool first_kinds = false;  ///< only kinds of call that there were at first: an old program stays the same
  bool trace = false;        ///< each call is told on standard error
};

/// Runs it in worlds of the variants, side by side. Throws Finding where one of them does what it should not: see
/// lockstep.h and consistency.h. What is recorded is replayed, and what is saved restored.
ProgramResult run_program(std::span<const std::uint8_t> bytes, Numbers numbers, std::span<const Variant> variants,
                          const ProgramLimits& limits = {});

}  // namespace atl::fuzz
