#pragma once

#include <jobs/arrays.h>
#include <solver/select/load_estimate.h>

#include <cstdint>
#include <span>
#include <vector>

namespace atl::solver {

/// How an island is solved.
enum class SolveMode : std::uint8_t {
  Sweep,    ///< as the settings say
  Refined,  ///< in more substeps
  Landing,  ///< in more substeps, for a step in which something lands
  Direct,   ///< at once
};

/// How many substeps an island gets for each that was asked for, a power of two; 1 where these are as short already.
int refinement_of(const SolverSettings& settings, double dt);

/// Follows which contacts carry more than soft ones are made for, and says what is done about their islands. A load has
/// to stay for some steps, or it is an impact; of bodies that are new it is estimated at once. Tall columns, heavy
/// bodies on light ones and large walls are what it finds, and landings of bodies alone. While there are none it costs
/// nothing.
class SolverSelection {
 public:
  /// For a world of so many bodies: ahead of a choice, where something moves. The others carry nothing that counts.
  void resize(std::size_t bodies);
  /// A new dynamic body.
  void arrive(std::uint32_t body) { arrived_.push_back(body); }
  /// One that is gone.
  void forget(std::uint32_t body);
  /// Where nothing is to be done.
  void forget_all();
  void forget_arrived() { arrived_.clear(); }

  /// By island, where all are to be solved at once that can be.
  std::span<const SolveMode> choose_direct(const LoadInput& input);

  /// By island, for the next step; empty if all are to be swept.
  std::span<const SolveMode> choose(const LoadInput& input);

  /// Chooses modes where contacts are swept whatever they carry: only islands of joints alone are solved at once.
  std::span<const SolveMode> choose_untouched(const LoadInput& input);

  /// Why an island got its mode, by the last choice; in words, static storage.
  const char* why(std::size_t island) const;

  /// An island that choose_direct() left to sweeps, and why, likewise.
  struct Refused {
    std::size_t island;
    const char* why;
  };
  std::span<const Refused> refused() const { return refused_; }

  /// After a step of dt seconds: overloaded bodies, in any order and any number of times each, and bodies of islands
  /// that could not be solved at once, likewise, which are swept for tuning::failed_time, whatever they carry. What
  /// sleeps stays as it is.
  void note(std::vector<OverloadedBody>& overloaded, std::vector<std::uint32_t>& failed,
            std::span<const std::uint8_t> awake, double dt);

  /// For how long a body has been overloaded, and deep in what it presses on, more or less: what lasts from step to
  /// step.
  struct LoadHistory {
    float overloaded = 0;  ///< s; below 0 for how long it is swept yet, after it could not be solved at once
    float deep = 0;        ///< s
    bool sags = false;     ///< with a large part of its island
    bool operator==(const LoadHistory&) const = default;
  };
  /// Bodies that came since the last choice, in the order in which they did.
  std::span<const std::uint32_t> arrived() const { return arrived_; }
  /// Bodies with a history, in order.
  std::span<const std::uint32_t> loaded() const { return loaded_; }
  LoadHistory load_history(std::uint32_t body) const {
    return body < load_history_.size() ? load_history_[body] : LoadHistory{};
  }
  /// Of a state that is restored: bodies with a history come in order.
  void restore_load_history(std::uint32_t body, const LoadHistory& history) {
    if (body >= load_history_.size()) resize(body + std::size_t{1});
    load_history_[body] = history;
    loaded_.push_back(body);
  }

  /// See jobs/arrays.h.
  auto arrays() const {
    return std::tie(load_history_, loaded_, arrived_, overloaded_now_, merged_, symptoms_, modes_, estimated_, joined_,
                    landings_, on_system_, refused_);
  }

 private:
  void estimate_arrived(const LoadInput& input);
  void find_landings(const LoadInput& input);
  void find_joined(const LoadInput& input, bool touched);
  void start_modes(const Islands& islands);
  bool is_machine(const LoadInput& input, std::size_t island);
  bool is_pressed(const LoadInput& input, std::size_t island);

  // What is known of an island by its loaded bodies.
  struct Symptoms {
    bool failed = false;  // to solve it at once was tried in vain, not long ago
    bool lasts = false;
    bool deep = false;
    bool sags = false;
  };

  // What lasts from step to step, and what is made anew. Whoever adds a member says which it is, or this won't compile.
  static void check_members(SolverSelection& selection) {
    auto& [history, loaded, arrived, /**/ overloaded, merged, symptoms, landings, joined, on_system, modes, refused,
           estimated, estimate] = selection;
    static_cast<void>(history);
  }

  std::vector<LoadHistory> load_history_;  // by body
  std::vector<std::uint32_t> loaded_;      // in order
  std::vector<std::uint32_t> arrived_;
  std::vector<std::uint32_t> overloaded_now_, merged_;
  std::vector<Symptoms> symptoms_;       // by island
  std::vector<std::size_t> landings_;    // islands in which something lands
  std::vector<std::size_t> joined_;      // islands that are solved at once for the sake of their joints
  std::vector<std::uint8_t> on_system_;  // by body of an island
  std::vector<SolveMode> modes_;         // by island
  std::vector<Refused> refused_;
  std::vector<OverloadedBody> estimated_;
  LoadEstimate estimate_;
};

}  // namespace atl::solver
