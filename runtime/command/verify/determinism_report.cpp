#include "determinism_report.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <nlohmann/json.hpp>
#include <ostream>

#include "../figures.h"
#include "../names.h"
#include "state/hex.h"

namespace atl::command {
namespace {

using Json = nlohmann::ordered_json;
using divergence::BodyDifference;
using divergence::Divergence;
using divergence::PartDifference;
using divergence::Restore;
using divergence::Variant;

constexpr std::size_t max_bodies_of_run = 10;  // that the text lists of a run
constexpr int threads_width = 7, simd_width = 10, restore_width = 10;

const char* name_of(Restore restore) {
  switch (restore) {
    case Restore::Never:
      return "never";
    case Restore::SameWorld:
      return "same";
    case Restore::FreshWorld:
      return "fresh";
  }
  return "?";
}

// The columns of the text that describe how a run is made.
class Columns {
 public:
  explicit Columns(const DeterminismResult& result)
      : restores_(std::any_of(result.others.begin(), result.others.end(),
                              [](const VariantResult& other) { return other.variant.restore != Restore::Never; })) {}

  void write_head(std::ostream& out, const std::string& words) const {
    write(out, "threads", "simd", "restored", words);
  }
  void write_run(std::ostream& out, const Variant& variant, const std::string& words) const {
    write(out, std::to_string(variant.threads), command::name_of(variant.simd), name_of(variant.restore), words);
  }
  void write_more(std::ostream& out, const std::string& words) const {
    out << std::string(threads_width + 2 + simd_width + (restores_ ? restore_width : 0), ' ') << words << "\n";
  }

 private:
  void write(std::ostream& out, const std::string& threads, const char* simd, const char* restore,
             const std::string& words) const {
    out << std::right << std::setw(threads_width) << threads << "  " << std::left << std::setw(simd_width) << simd;
    if (restores_) out << std::setw(restore_width) << restore;
    out << words << "\n";
  }

  bool restores_;
};

std::string body_words(const Scene& scene, const BodyDifference& body) {
  std::string words = command::body_words(scene, body.body);
  for (const PartDifference& part : body.parts) {
    words += (&part == &body.parts.front() ? ": " : ", ") + part.part;
    if (part.by) words += " by " + significant(*part.by, 3) + " " + part.unit;
  }
  return words;
}

// Names the difference if no body differs, or it isn't known which.
std::string other_words(const Divergence& divergence) {
  if (!divergence.seen_again) return "not seen again in a second run, so a matter of timing";
  if (divergence.events) return "events or their order";
  return beside_bodies;
}

void write_divergence(std::ostream& out, const Columns& columns, const Scene& scene, const VariantResult& result) {
  const Divergence& divergence = *result.divergence;
  const std::size_t count = divergence.bodies.size();
  std::string words = "differs in step " + std::to_string(divergence.step) + ": ";
  words += count == 0 ? other_words(divergence) : plural(static_cast<std::int64_t>(count), "body", "bodies");
  columns.write_run(out, result.variant, words);
  for (std::size_t i = 0; i < std::min(count, max_bodies_of_run); ++i) {
    columns.write_more(out, body_words(scene, divergence.bodies[i]));
  }
  if (count > max_bodies_of_run) columns.write_more(out, "and " + std::to_string(count - max_bodies_of_run) + " more");
}

Json variant_json(const Variant& variant) {
  return {
      {"threads", variant.threads}, {"simd", command::name_of(variant.simd)}, {"restore", name_of(variant.restore)}};
}

Json part_json(const PartDifference& part) {
  Json object = {{"part", part.part}};
  if (part.by) object["by"] = std::isfinite(*part.by) ? Json(*part.by) : Json();
  if (part.by) object["unit"] = part.unit;
  return object;
}

Json divergence_json(const Scene& scene, const Divergence& divergence) {
  Json bodies = Json::array();
  for (const BodyDifference& body : divergence.bodies) {
    Json parts = Json::array();
    for (const PartDifference& part : body.parts) parts.push_back(part_json(part));
    bodies.push_back({{"body", body.body}, {"name", scene.bodies[body.body].name}, {"differs", std::move(parts)}});
  }
  return {{"step", divergence.step},
          {"seen_again", divergence.seen_again},
          {"events", divergence.events},
          {"elsewhere", divergence.elsewhere},
          {"bodies", std::move(bodies)}};
}

}  // namespace

std::string first_words(const Scene& scene, const Divergence& divergence) {
  return "step " + std::to_string(divergence.step) + ", " +
         (divergence.bodies.empty() ? other_words(divergence) : body_words(scene, divergence.bodies.front()));
}

void write_determinism_text(std::ostream& out, const Scene& scene, const DeterminismResult& result) {
  out << "scene     " << scene.name << "\n"
      << "run       " << plural(scene.steps, "step") << " of " << significant(1000 * scene.dt, 4) << " ms\n\n";
  const Columns columns(result);
  columns.write_head(out, "state and events");
  columns.write_run(out, result.baseline, "hash " + hash_text(result.hash) + " after the last step");
  std::size_t same = 0;
  for (const VariantResult& other : result.others) {
    if (other.divergence) {
      write_divergence(out, columns, scene, other);
    } else {
      ++same;
      columns.write_run(out, other.variant, "same after every step");
    }
  }
  out << "\n" << same << " of " << result.others.size() << " runs are the same as the first, bit for bit\n";
}

void write_determinism_json(std::ostream& out, const Scene& scene, const DeterminismResult& result) {
  Json runs = Json::array();
  bool same = true;
  for (const VariantResult& other : result.others) {
    Json run = variant_json(other.variant);
    run["same"] = !other.divergence;
    if (other.divergence) run["divergence"] = divergence_json(scene, *other.divergence);
    same = same && !other.divergence;
    runs.push_back(std::move(run));
  }
  const Json object = {{"format", "atoll-determinism"},
                       {"version", 1},
                       {"scene", scene.name},
                       {"steps", scene.steps},
                       {"dt", scene.dt},
                       {"same", same},
                       {"baseline", variant_json(result.baseline)},
                       {"hash", hash_text(result.hash)},
                       {"runs", std::move(runs)}};
  // A name from a scene file is valid UTF-8 by then; one from a file's name need not be.
  out << object.dump(2, ' ', false, Json::error_handler_t::replace) << '\n';
}

}  // namespace atl::command
