#include "replay_report.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <ostream>

#include "names.h"
#include "state/hex.h"

namespace atl::command {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t max_bodies = 10;  // that the text lists

// Names the difference if no body is known to differ.
std::string other_words(const ReplayDivergence& divergence) {
  if (!divergence.bodies_step) return "the recording doesn't tell of which bodies";
  return beside_bodies;
}

std::string run_words(int threads, Simd simd) { return plural(threads, "thread") + ", " + name_of(simd); }

Json run_json(int threads, Simd simd) { return {{"threads", threads}, {"simd", name_of(simd)}}; }

Json divergence_json(const ReplayDivergence& divergence) {
  Json bodies = Json::array();
  for (const ReplayedBody& body : divergence.bodies) {
    bodies.push_back({{"body", body.id.index}, {"generation", body.id.generation}, {"differs", body.parts}});
  }
  return {{"step", divergence.step},
          {"bodies_step", divergence.bodies_step ? Json(*divergence.bodies_step) : Json()},
          {"bodies", std::move(bodies)}};
}

}  // namespace

std::string body_words(const ReplayedBody& body) {
  std::string words = "body " + std::to_string(body.id.index);
  if (body.id.generation > 0) words += " (generation " + std::to_string(body.id.generation) + ")";
  for (const std::string& part : body.parts) words += (&part == &body.parts.front() ? ": " : ", ") + part;
  return words;
}

void write_bodies(std::ostream& out, const std::vector<ReplayedBody>& bodies) {
  const std::string indent(11, ' ');
  for (std::size_t i = 0; i < std::min(bodies.size(), max_bodies); ++i) out << indent << body_words(bodies[i]) << "\n";
  if (bodies.size() > max_bodies) out << indent << "and " << bodies.size() - max_bodies << " more\n";
}

std::string first_words(const ReplayDivergence& divergence) {
  std::string words = "step " + std::to_string(divergence.step);
  if (divergence.bodies.empty()) return words + ", " + other_words(divergence);
  if (*divergence.bodies_step > divergence.step) {
    words += ", and by step " + std::to_string(*divergence.bodies_step);
  }
  return words + ", " + body_words(divergence.bodies.front());
}

void write_replay_text(std::ostream& out, const ReplayFileOptions& options, const ReplayResult& result) {
  out << "recording  " << options.path << "\n"
      << "recorded   " << plural(result.recorded_steps, "step") << (result.complete ? "" : ", where it is cut off")
      << "; " << run_words(result.recorded_threads, result.recorded_simd) << "\n"
      << "replayed   " << plural(result.steps, "step") << "; " << run_words(options.threads, result.simd) << "\n";
  if (!result.divergence) {
    out << "result     same after every step" << (result.steps < result.recorded_steps ? " so far" : "")
        << ", bit for bit; hash " << hash_text(result.hash) << "\n";
    return;
  }
  const ReplayDivergence& divergence = *result.divergence;
  const std::size_t count = divergence.bodies.size();
  out << "result     differs in step " << divergence.step << ": "
      << (count == 0 ? other_words(divergence) : plural(static_cast<std::int64_t>(count), "body", "bodies"));
  if (count > 0 && *divergence.bodies_step > divergence.step) out << " by step " << *divergence.bodies_step;
  out << "\n";
  write_bodies(out, divergence.bodies);
}

void write_replay_json(std::ostream& out, const ReplayFileOptions& options, const ReplayResult& result) {
  Json object = {{"format", "atoll-replay"},
                 {"version", 1},
                 {"recording", options.path},
                 {"recorded", run_json(result.recorded_threads, result.recorded_simd)},
                 {"replayed", run_json(options.threads, result.simd)},
                 {"recorded_steps", result.recorded_steps},
                 {"complete", result.complete},
                 {"steps", result.steps},
                 {"same", !result.divergence},
                 {"hash", hash_text(result.hash)}};
  if (result.divergence) object["divergence"] = divergence_json(*result.divergence);
  // A file's name need not be valid UTF-8.
  out << object.dump(2, ' ', false, Json::error_handler_t::replace) << '\n';
}

}  // namespace atl::command
