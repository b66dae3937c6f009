#pragma once
/// Runs of a scene that must be the same, bit for bit.

#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

#include "checks/divergence/divergence.h"
#include "support/long_tests.h"
#include "world/simd_names.h"

namespace atl::test {

/// Runs that must come to the same bits: each set of instructions of the machine with the first of these numbers of threads,
/// and the best set with the others. In long tests each set with each number.
inline std::vector<divergence::Variant> variants_of(const std::vector<int>& threads) {
  std::vector<divergence::Variant> variants;
  const std::vector<Simd> simds = divergence::supported_simds();
  for (const Simd simd : simds) {
    for (const int count : threads) {
      if (long_tests() || count == threads.front() || simd == simds.back()) variants.push_back({count, simd});
    }
  }
  return variants;
}

/// Sets of instructions for runs of which others have shown all: the best one, in long tests all.
inline std::vector<Simd> simds_to_try() {
  const std::vector<Simd> simds = divergence::supported_simds();
  return long_tests() ? simds : std::vector<Simd>{simds.back()};
}

/// Expects that a run keeps to the trail of the run of `first`; else names the step and the first body that differs.
inline void expect_same(const std::vector<std::uint64_t>& trail, const Scene& scene, const divergence::Variant& first,
                        const divergence::Variant& other) {
  const auto step = divergence::first_difference(trail, scene, other);
  if (!step) return;
  const divergence::Divergence found = divergence::explain(scene, first, other, *step);
  std::string body;
  if (!found.bodies.empty()) {
    body = ", first in body " + std::to_string(found.bodies.front().body);
    for (const divergence::PartDifference& part : found.bodies.front().parts) body += ", " + part.part;
  }
  ADD_FAILURE() << "diverges in step " << *step << " with " << other.threads << " threads on " << name_of(other.simd)
                << body << (found.seen_again ? "" : "; not in a second run");
}

}  // namespace atl::test
