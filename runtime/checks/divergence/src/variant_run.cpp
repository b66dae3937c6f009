#include "checks/divergence/variant_run.h"

#include <jobs/hash.h>

#include <utility>

namespace atl::divergence {
namespace {

WorldDef world_def(const Scene& scene, const Variant& variant) {
  WorldDef def{
      .gravity = scene.gravity, .threads = variant.threads, .dynamic_threads = false, .settings = scene.settings};
  def.settings.simd = variant.simd;
  def.settings.contact_events = true;
  return def;
}

// One step in four, without a period that a scene could share.
bool restores_ahead_of(std::int64_t step) {
  jobs::Hash hash;
  hash.add(static_cast<std::uint64_t>(step));
  return hash.value() % 4 == 0;
}

std::uint64_t word(std::uint32_t high, std::uint32_t low) { return std::uint64_t{high} << 32 | low; }

}  // namespace

std::vector<Simd> supported_simds() {
  std::vector<Simd> simds;
  for (const Simd simd : {Simd::Portable, Simd::Sse4, Simd::Avx2, Simd::Avx512, Simd::Neon}) {
    try {
      const World world({.settings = {.simd = simd}});
      simds.push_back(simd);
    } catch (const Error&) {  // this machine lacks it
    }
  }
  return simds;
}

VariantRun::VariantRun(const Scene& scene, const Variant& variant, Meddle meddle)
    : scene_(scene), variant_(variant), meddle_(std::move(meddle)), world_(world_def(scene, variant)) {
  ids_ = build_scene(scene, world_);
}

void VariantRun::step() {
  ++steps_;
  if (variant_.restore != Restore::Never && restores_ahead_of(steps_)) save_and_restore();
  if (meddle_) meddle_(world_, ids_, steps_, variant_);
  advance();
}

void VariantRun::advance() {
  apply_forces(scene_, world_, ids_);
  world_.step(scene_.dt);
}

void VariantRun::save_and_restore() {
  world_.save(snapshot_);
  if (variant_.restore == Restore::FreshWorld) {
    world_ = World(world_def(scene_, variant_));
  } else {
    for (std::int64_t ahead = 0; ahead <= steps_ % 3; ++ahead) advance();
  }
  world_.restore(snapshot_);
}

std::uint64_t VariantRun::hash() const {
  jobs::Hash hash;
  hash.add(world_.state_hash());
  for (const ContactEvent& event : world_.contact_events()) {
    hash.add(word(event.a.index, event.b.index));
    hash.add(word(event.a.generation, event.b.generation));
    hash.add(std::uint64_t{event.began});
  }
  for (const JointEvent& event : world_.joint_events()) {
    hash.add(word(event.joint.index, event.joint.generation));
    hash.add(static_cast<std::uint64_t>(event.kind));
  }
  return hash.value();
}

}  // namespace atl::divergence
