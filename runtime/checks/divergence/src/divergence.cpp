#include "checks/divergence/divergence.h"

#include "state/body_hashes.h"

namespace atl::divergence {
namespace {

void tell(const OnStep& on_step, std::int64_t steps) {
  if (on_step) on_step(steps);
}

// Adds the differences of a pose, or of velocities, with their sizes.
void note(std::vector<PartDifference>& parts, const char* linear, const char* linear_unit, double linear_by,
          const char* angular, const char* angular_unit, double angular_by) {
  // Not finite ones are not zero either.
  const bool turns = !(angular_by == 0);
  if (!(linear_by == 0) || !turns) parts.push_back({linear, linear_by, linear_unit});
  if (turns) parts.push_back({angular, angular_by, angular_unit});
}

// Norms of differences don't underflow.
BodyDifference difference(std::size_t body, const BodyHash& a, const BodyHash& b, const BodyState& at,
                          const BodyState& other) {
  BodyDifference result{body, {}};
  for (const auto& [name, part] : body_parts) {
    if (a.*part == b.*part) continue;
    if (part == &BodyHash::pose) {
      // Quaternions a small angle apart are half as far from each other.
      note(result.parts, "position", "m", (other.pose.position - at.pose.position).stableNorm(), "orientation", "rad",
           2 * (other.pose.orientation.coeffs() - at.pose.orientation.coeffs()).stableNorm());
    } else if (part == &BodyHash::velocity) {
      note(result.parts, "velocity", "m/s", (other.velocity - at.velocity).stableNorm(), "angular_velocity", "rad/s",
           (other.angular_velocity - at.angular_velocity).stableNorm());
    } else {
      result.parts.push_back({name});
    }
  }
  return result;
}

}  // namespace

std::vector<std::uint64_t> follow(const Scene& scene, const Variant& variant, const OnStep& on_step,
                                  const Meddle& meddle) {
  VariantRun run(scene, variant, meddle);
  std::vector<std::uint64_t> trail = {run.hash()};
  while (run.steps() < scene.steps) {
    run.step();
    trail.push_back(run.hash());
    tell(on_step, run.steps());
  }
  return trail;
}

std::optional<std::int64_t> first_difference(const std::vector<std::uint64_t>& trail, const Scene& scene,
                                             const Variant& variant, const OnStep& on_step, const Meddle& meddle) {
  VariantRun run(scene, variant, meddle);
  for (const std::uint64_t expected : trail) {
    if (run.steps() > 0) tell(on_step, run.steps());
    if (run.hash() != expected) return run.steps();
    if (run.steps() + 1 < static_cast<std::int64_t>(trail.size())) run.step();
  }
  return std::nullopt;
}

Divergence explain(const Scene& scene, const Variant& first, const Variant& second, std::int64_t step,
                   const OnStep& on_step, const Meddle& meddle) {
  VariantRun a(scene, first, meddle);
  VariantRun b(scene, second, meddle);
  while (a.hash() == b.hash()) {
    if (a.steps() == step) return {.step = step};
    a.step();
    b.step();
    tell(on_step, a.steps());
  }
  Divergence result{.step = a.steps(), .seen_again = true, .bodies = compare(a, b)};
  const bool same_state = a.world().state_hash() == b.world().state_hash();
  result.events = same_state;
  result.elsewhere = !same_state && result.bodies.empty();
  return result;
}

std::vector<BodyDifference> compare(const VariantRun& a, const VariantRun& b) {
  const std::vector<BodyHash> hashes_a = a.world().body_hashes();
  const std::vector<BodyHash> hashes_b = b.world().body_hashes();
  std::vector<BodyDifference> differences;
  for (std::size_t i = 0; i < a.ids().size(); ++i) {
    const BodyId id_a = a.ids()[i];
    const BodyId id_b = b.ids()[i];
    const BodyHash& hash_a = hashes_a[id_a.index];
    const BodyHash& hash_b = hashes_b[id_b.index];
    if (hash_a == hash_b) continue;
    differences.push_back(difference(i, hash_a, hash_b, a.world().state(id_a), b.world().state(id_b)));
  }
  return differences;
}

}  // namespace atl::divergence
