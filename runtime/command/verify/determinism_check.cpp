#include <algorithm>
#include <iostream>
#include <optional>

#include "../failure.h"
#include "../interrupt.h"
#include "../names.h"
#include "../progress.h"
#include "../standard_streams.h"
#include "checks.h"
#include "determinism_report.h"

namespace atl::command {
namespace {

using divergence::Restore;
using divergence::Variant;

std::vector<Simd> chosen_simds(const VerifyOptions& options) {
  const std::vector<Simd> supported = divergence::supported_simds();
  std::vector<Simd> chosen;
  for (const std::string& name : options.simds) {
    if (name == "all") {
      chosen.insert(chosen.end(), supported.begin(), supported.end());
      continue;
    }
    const Simd simd = simd_named(name);
    if (simd != Simd::Auto && std::find(supported.begin(), supported.end(), simd) == supported.end()) {
      std::string names;
      for (const Simd known : supported) names += (names.empty() ? "" : ", ") + std::string(name_of(known));
      throw Failure(Status::Usage, "--simd: found " + name + ", which this machine lacks; expected some of " + names);
    }
    chosen.push_back(simd);
  }
  return chosen;
}

// The first is what the others are held to. One alone is held to itself, run again.
std::vector<Variant> variants_of(const VerifyOptions& options) {
  std::vector<Restore> restores = {Restore::Never};
  if (options.restore) restores.insert(restores.end(), {Restore::SameWorld, Restore::FreshWorld});
  std::vector<Variant> variants;
  for (const int threads : options.threads) {
    for (const Simd simd : chosen_simds(options)) {
      for (const Restore restore : restores) variants.push_back({threads, simd, restore});
    }
  }
  if (variants.size() == 1) variants.push_back(variants.front());
  return variants;
}

// Throws Interrupted in the first run, without which there is nothing to compare; a later one ends the list of others.
DeterminismResult run_variants(const Scene& scene, const std::vector<Variant>& variants,
                               const divergence::Meddle& meddle) {
  Progress progress(scene.steps * static_cast<std::int64_t>(variants.size()));
  std::int64_t before = 0;
  const auto show = [&](std::int64_t steps) {
    stop_if_interrupted();
    progress.update(before + steps);
  };

  const std::vector<std::uint64_t> trail = divergence::follow(scene, variants.front(), show, meddle);
  DeterminismResult result{.baseline = variants.front(), .hash = trail.back(), .others = {}};
  for (std::size_t i = 1; i < variants.size(); ++i) {
    before += scene.steps;
    VariantResult other{.variant = variants[i], .divergence = {}};
    try {
      if (const auto step = divergence::first_difference(trail, scene, variants[i], show, meddle)) {
        other.divergence = divergence::explain(scene, variants.front(), variants[i], *step, {}, meddle);
      }
    } catch (const Interrupted&) {
      break;
    }
    result.others.push_back(std::move(other));
  }
  return result;
}

void throw_first_of(const Scene& scene, const DeterminismResult& result) {
  const VariantResult* first = nullptr;
  std::size_t count = 0;
  for (const VariantResult& other : result.others) {
    if (!other.divergence) continue;
    ++count;
    if (first == nullptr || other.divergence->step < first->divergence->step) first = &other;
  }
  if (count == 0) return;
  throw Failure(Status::CheckFailed,
                scene.name + ": " + std::to_string(count) + " of " + std::to_string(result.others.size()) +
                    " runs differ from the first; earliest: " + first_words(scene, *first->divergence));
}

}  // namespace

void check_determinism(const VerifyOptions& options, const divergence::Meddle& meddle) {
  const std::vector<Variant> variants = variants_of(options);
  const Scene scene = load(options.scene);
  const std::size_t compared = variants.size() - 1;
  std::optional<DeterminismResult> found;
  try {
    found = run_variants(scene, variants, meddle);
  } catch (const Interrupted&) {
    throw interruption(scene.name, "in the first run, with none to compare it to");
  }
  const DeterminismResult& result = *found;
  if (options.format == Format::Json) {
    write_determinism_json(std::cout, scene, result);
  } else {
    write_determinism_text(std::cout, scene, result);
  }
  finish_output();
  throw_first_of(scene, result);
  if (result.others.size() < compared) {
    throw interruption(scene.name, "with " + std::to_string(result.others.size()) + " of " + std::to_string(compared) +
                                       " runs compared to the first");
  }
}

}  // namespace atl::command
