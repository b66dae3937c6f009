#pragma once

// Writes the results of a group back to the bodies and to the reports. Bodies are the group's dynamic ones, by their
// place in it.

#include <solver/sweep/group_parts.h>
#include <solver/sweep/group_report.h>

#include <cstddef>
#include <cstdint>
#include <span>

namespace atl::solver {

// Poses and velocities of bodies [begin, end); `joined` says whether there are joints.
void write_back(const SolveInput& input, const GroupParts& parts, std::span<const std::uint32_t> bodies, bool joined,
                std::size_t begin, std::size_t end);

// Fills SolveInput::capture for the group, in its last substep.
void capture_answers(const SolveInput& input, const GroupParts& parts, const GroupReport& report,
                     std::span<const std::uint32_t> bodies);

}  // namespace atl::solver
