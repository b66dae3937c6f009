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
using Columns = std::vector<std::pair<std::string, std::string>>;  // names and kinds

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
Number in_range(const char* name, Number value, Number most) {
  if (value > 0 && value <= most) return value;
  std::string words = nb::str(nb::cast(value)).c_str();
  throw Error("sweep: " + std::string(name) + " is " + words + "; expected a number above 0, at most " +
              std::string(nb::str(nb::cast(most)).c_str()));
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

std::pair<Columns, std::vector<std::vector<std::string>>> measure_sweep(const std::vector<Source>& scenes,
                                                                        const tradeoff::GridOptions& options,
                                                                        tradeoff::RunPolicy policy,
                                                                        const std::vector<std::string>& peers,
                                                                        double peer_limit, const nb::object& on_work) {
  const nb::gil_scoped_release release;
  Ending ending;
  policy.stop = [&] { return ending.asked(); };
  const std::vector<tradeoff::PeerDriver> drivers = drivers_of(peers, peer_limit, ending);
  std::vector<tradeoff::ScenePlan> plans;
  std::vector<std::int64_t> ends = {0};  // the work done by the end of each scene
  for (const Source& scene : scenes) {
    plans.push_back(plan_of(scene, options, !peers.empty()));
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
  return {std::move(columns), std::move(table.rows)};
}

}  // namespace

void bind_sweeps(nb::module_& module) {
  module.def(
      "measure_sweep",
      [](const std::vector<Source>& scenes, const std::map<std::string, std::vector<std::string>>& lists, bool quick,
         std::optional<int> steps, std::optional<int> repeats, std::optional<double> time, std::uint64_t seed,
         const std::vector<std::string>& peers, std::optional<double> peer_limit, const nb::object& on_work) {
        tradeoff::GridOptions options = {.lists = lists, .quick = quick, .steps = steps, .seed = seed};
        if (steps) in_range("steps", *steps, 1'000'000'000);
        tradeoff::RunPolicy policy = tradeoff::RunPolicy::usual(quick);
        policy.repeats = in_range("repeats", repeats.value_or(policy.repeats), 1000);
        policy.least_time = in_range("time", time.value_or(policy.least_time), 60.0);
        const double limit = peer_limit.value_or(quick ? tradeoff::quick_peer_limit : tradeoff::peer_limit);
        return measure_sweep(scenes, options, policy, peers, in_range("peer_limit", limit, 86400.0), on_work);
      },
      nb::arg("scenes"), nb::arg("lists"), nb::kw_only(), nb::arg("quick"), nb::arg("steps").none(),
      nb::arg("repeats").none(), nb::arg("time").none(), nb::arg("seed"), nb::arg("peers"),
      nb::arg("peer_limit").none(), nb::arg("on_work"),
      "What atoll.sweep() hands on. Columns, with what their texts stand for (\"text\", \"flag\", \"integer\" or "
      "\"number\"), and rows. on_work(done, of) is called as work gets done.",
      nb::sig(
          "def measure_sweep(scenes: collections.abc.Sequence[Scene | str], lists: collections.abc.Mapping[str, "
          "collections.abc.Sequence[str]], *, quick: bool, steps: int | None, repeats: int | None, time: float | None, "
          "seed: int, peers: collections.abc.Sequence[str], peer_limit: float | None, on_work: "
          "collections.abc.Callable[[int, int], None]) -> tuple[list[tuple[str, str]], list[list[str]]]"));
}

}  // namespace atl::python
