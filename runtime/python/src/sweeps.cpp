// Error against run time, as `atoll sweep` measures it.

#include <atoll/scene.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/pair.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

#include "checks/tradeoff/scene_sweep.h"
#include "checks/tradeoff/table.h"
#include "fields.h"
#include "parts.h"
#include "signals.h"

namespace atl::python {
namespace {

using Source = std::variant<Scene, std::string>;
using Lists = std::map<std::string, std::vector<std::string>>;
using Columns = std::vector<std::pair<std::string, std::string>>;  // names and kinds
using Cells = std::vector<std::vector<std::string>>;
using Part = std::tuple<int, int, int>;  // begin and end of configurations, and how many the whole plan has

// Ends what is measured once a handler of signals raised something.
class Ending {
 public:
  bool asked() {
    if (raised_) return true;
    try {
      check_signals_();
    } catch (nb::python_error& error) {
      raised_.emplace(std::move(error));
    }
    return raised_.has_value();
  }
  void rethrow() {
    if (raised_) throw std::move(*raised_);
  }

 private:
  SignalCheck check_signals_;
  std::optional<nb::python_error> raised_;
};

template <typename Number>
Number in_range(const char* name, Number value, Number max) {
  if (value > 0 && value <= max) return value;
  std::string words = nb::str(nb::cast(value)).c_str();
  throw Error("sweep: " + std::string(name) + " is " + words + "; expected a number above 0, at most " +
              std::string(nb::str(nb::cast(max)).c_str()));
}

tradeoff::GridOptions grid_options(const Lists& lists, bool quick, std::optional<int> steps, std::uint64_t seed) {
  if (steps) in_range("steps", *steps, 1'000'000'000);
  return {.lists = lists, .quick = quick, .steps = steps, .seed = seed};
}

std::vector<tradeoff::PeerDriver> drivers_of(const std::vector<std::string>& peers, double limit, Ending& ending) {
  try {
    return tradeoff::ask_drivers(peers, limit, [&] { return ending.asked(); });
  } catch (const tradeoff::DriverError& error) {
    throw Error(std::string("sweep: peers: ") + error.what());
  } catch (const tradeoff::Stopped&) {
    ending.rethrow();
    throw;
  }
}

tradeoff::ScenePlan plan_of(const Source& source, const tradeoff::GridOptions& options, bool peers) {
  try {
    if (const auto* address = std::get_if<std::string>(&source)) return plan_scene(*address, options);
    if (!peers) return plan_scene(std::get<Scene>(source), options);
  } catch (const SceneError&) {
    throw;
  } catch (const Error& error) {
    throw Error(std::string("sweep: ") + error.what());
  }
  throw Error("sweep: found a Scene beside peers, which are other programs; expected it by name or file");
}

void check_sent(const Source& source) {
  const auto* scene = std::get_if<Scene>(&source);
  if (scene == nullptr || !scene->closed_form) return;
  throw Error("sweep: found the Scene " + scene->name +
              ", whose known motion can't be sent to workers; expected it by name");
}

// How many configurations a sweep of each scene has.
std::vector<int> sweep_sizes(const std::vector<Source>& scenes, const tradeoff::GridOptions& options) {
  const nb::gil_scoped_release release;
  std::vector<int> sizes;
  for (const Source& scene : scenes) {
    check_sent(scene);
    sizes.push_back(static_cast<int>(plan_of(scene, options, false).configurations.size()));
  }
  return sizes;
}

// Keeps the configurations of one part of a plan, and ahead of them the scene's own, which others are compared with.
// Returns their indices in the whole plan.
std::vector<int> keep_part(tradeoff::ScenePlan& plan, const Part& part) {
  const auto [begin, end, whole] = part;
  const int size = static_cast<int>(plan.configurations.size());
  // By default a plan has all instruction sets of the machine that makes it.
  if (size != whole) {
    throw Error("sweep: found " + std::to_string(size) + " settings to try in " + plan.scene.name + ", expected " +
                std::to_string(whole) +
                " as on the machine that asks: their instruction sets differ; name those to try, as simd=\"auto\"");
  }
  if (begin < 0 || begin >= end || end > size) {
    throw Error("sweep: found the part " + std::to_string(begin) + " to " + std::to_string(end) +
                "; expected a range in 0 to " + std::to_string(size));
  }
  std::vector<int> kept = {0};
  for (int i = std::max(begin, 1); i < end; ++i) kept.push_back(i);
  std::vector<tradeoff::Configuration> configurations;
  for (const int i : kept) configurations.push_back(std::move(plan.configurations[static_cast<std::size_t>(i)]));
  plan.configurations = std::move(configurations);
  return kept;
}

void check_part(std::size_t scenes, std::size_t peers) {
  if (scenes == 1 && peers == 0) return;
  throw Error("sweep: found a part of " + std::to_string(scenes) + " scenes and " + std::to_string(peers) +
              " peers; expected one scene and no peers");
}

// Says first of each row which configuration it is of.
void add_indices(const std::vector<int>& indices, Columns& columns, Cells& rows) {
  columns.insert(columns.begin(), {"configuration", name_of(tradeoff::Table::Kind::Integer)});
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i].insert(rows[i].begin(), std::to_string(indices[i]));
}

std::pair<Columns, Cells> measure_sweep(const std::vector<Source>& scenes, const tradeoff::GridOptions& options,
                                        tradeoff::RunPolicy policy, const std::vector<std::string>& peers,
                                        double peer_limit, const nb::object& on_work, const std::optional<Part>& part) {
  const nb::gil_scoped_release release;
  if (part) check_part(scenes.size(), peers.size());
  Ending ending;
  policy.stop = [&] { return ending.asked(); };
  const std::vector<tradeoff::PeerDriver> drivers = drivers_of(peers, peer_limit, ending);
  std::vector<tradeoff::ScenePlan> plans;
  std::vector<int> indices;              // of the configurations of a part
  std::vector<std::int64_t> ends = {0};  // the work done by the end of each scene
  for (const Source& scene : scenes) {
    plans.push_back(plan_of(scene, options, !peers.empty()));
    if (part) indices = keep_part(plans.back(), *part);
    ends.push_back(ends.back() + estimate_work(plans.back(), drivers, policy));
  }
  const auto tell = [&](std::int64_t done) {
    const nb::gil_scoped_acquire lock;
    on_work(done, ends.back());
  };
  std::vector<tradeoff::SceneReport> reports;
  for (std::size_t i = 0; i < plans.size(); ++i) {
    std::int64_t done = ends[i];
    const tradeoff::WorkDone work_done = [&](std::int64_t more) { tell(done += more); };
    reports.push_back(sweep_scene(std::move(plans[i]), drivers, policy, options.seed, work_done));
    ending.rethrow();
    tell(ends[i + 1]);  // less, where runs broke and were not timed
  }
  tradeoff::Table table = tradeoff::table_of(reports);
  Columns columns;
  for (const tradeoff::Table::Column& column : table.columns) columns.emplace_back(column.name, name_of(column.kind));
  if (part) add_indices(indices, columns, table.rows);
  return {std::move(columns), std::move(table.rows)};
}

}  // namespace

void bind_sweeps(nb::module_& module) {
  module.def(
      "sweep_sizes",
      [](const std::vector<Source>& scenes, const Lists& lists, bool quick, std::optional<int> steps,
         std::uint64_t seed) { return sweep_sizes(scenes, grid_options(lists, quick, steps, seed)); },
      nb::arg("scenes"), nb::arg("lists"), nb::kw_only(), nb::arg("quick"), nb::arg("steps").none(), nb::arg("seed"),
      "How many configurations measure_sweep() runs each scene with, for parts of sweeps; raises Error on what workers "
      "can't be sent.",
      nb::sig("def sweep_sizes(scenes: collections.abc.Sequence[Scene | str], lists: collections.abc.Mapping[str, "
              "collections.abc.Sequence[str]], *, quick: bool, steps: int | None, seed: int) -> list[int]"));
  module.def(
      "measure_sweep",
      [](const std::vector<Source>& scenes, const Lists& lists, bool quick, std::optional<int> steps,
         std::optional<int> repeats, std::optional<double> time, std::uint64_t seed,
         const std::vector<std::string>& peers, std::optional<double> peer_limit, const nb::object& on_work,
         const std::optional<Part>& part) {
        const tradeoff::GridOptions options = grid_options(lists, quick, steps, seed);
        tradeoff::RunPolicy policy = tradeoff::RunPolicy::standard(quick);
        policy.repeats = in_range("repeats", repeats.value_or(policy.repeats), 1000);
        policy.min_time = in_range("time", time.value_or(policy.min_time), 60.0);
        const double limit = peer_limit.value_or(quick ? tradeoff::quick_peer_limit : tradeoff::peer_limit);
        return measure_sweep(scenes, options, policy, peers, in_range("peer_limit", limit, 86400.0), on_work, part);
      },
      nb::arg("scenes"), nb::arg("lists"), nb::kw_only(), nb::arg("quick"), nb::arg("steps").none(),
      nb::arg("repeats").none(), nb::arg("time").none(), nb::arg("seed"), nb::arg("peers"),
      nb::arg("peer_limit").none(), nb::arg("on_work"), nb::arg("part").none() = nb::none(),
      "What atoll.sweep() hands on. Columns, with what their texts stand for (\"text\", \"flag\", \"integer\" or "
      "\"number\"), and rows. on_work(done, of) is called as work gets done; what it raises ends all. part: of a "
      "single scene, the scene's own configuration and those from begin to end, of so many that sweep_sizes() has; a "
      "first column tells their indices.",
      nb::sig("def measure_sweep(scenes: collections.abc.Sequence[Scene | str], lists: collections.abc.Mapping[str, "
              "collections.abc.Sequence[str]], *, quick: bool, steps: int | None, repeats: int | None, time: float | "
              "None, seed: int, peers: collections.abc.Sequence[str], peer_limit: float | None, on_work: "
              "collections.abc.Callable[[int, int], None], part: tuple[int, int, int] | None = None) -> "
              "tuple[list[tuple[str, str]], list[list[str]]]"));
}

}  // namespace atl::python
