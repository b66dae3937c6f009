#pragma once
/// Shared by the drivers of other engines: the command line, the run, its timing and its report. A driver turns an
/// atl::Scene into its engine's world and gives the bodies' states back; atl::ErrorMeter measures errors on those, as
/// for Atoll itself.

#include <atoll/scene.h>

#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace peer {

/// How an engine is to solve a step.
struct Setting {
  int substeps = 1;     ///< engine steps in a step of the scene, each of dt / substeps
  int iterations = 0;   ///< of the engine's solver
  std::string variant;  ///< one of Engine::variants
};

/// A setting worth measuring, as the command line takes it.
struct NamedSetting {
  std::string label;
  std::vector<std::string> options;
  bool large = false;  ///< worth the time in scenes of thousands of bodies too
};

/// m/s: as fast as Atoll lets things bounce where the scene doesn't say.
inline double threshold_of(const atl::Scene& scene) {
  const atl::Settings& settings = scene.settings;
  return settings.restitution_threshold.value_or(2 * scene.gravity.norm() * scene.dt / settings.substeps);
}

/// A scene in another engine, at Setting::substeps engine steps a step.
class Simulation {
 public:
  Simulation() = default;
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;
  virtual ~Simulation() = default;

  virtual void step() = 0;
  /// True if the scene outgrew a fixed capacity and a step had to set the simulation up anew. The next simulation of
  /// the scene starts with enough, so the times of this one don't count.
  virtual bool started_over() const { return false; }
  virtual std::vector<atl::BodyState> states() const = 0;  ///< in the order of the scene's bodies

  /// From now on loads() will be asked for.
  virtual void keep_loads() {}
  /// Contact loads of the last engine step: one entry a pair of bodies (a before b), in order.
  virtual std::vector<atl::ContactLoad> loads() const = 0;
};

/// Thrown by a step of an engine that noticed so itself.
class NonFinite : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct Engine {
  std::string name;
  std::string version;
  std::string precision;              ///< "single" or "double"
  int iterations = 0;                 ///< the engine's default
  std::vector<std::string> variants;  ///< the default first
  std::vector<NamedSetting> settings;
  /// Throws atl::Error on a scene that the engine or its driver has no equal for.
  std::function<std::unique_ptr<Simulation>(const atl::Scene&, const Setting&)> load;
};

/// A driver's main. Returns its exit status: 0, 2 on a wrong command line, 3 on an unusable scene, 4 on a
/// state that is not finite.
int run(const Engine& engine, int argc, char** argv);

}  // namespace peer
