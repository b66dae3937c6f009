#pragma once
/// What the drivers of other engines share: the command line, the run, its timing and its report. A driver
/// turns an atl::Scene into its engine's world and gives the bodies' state back; errors are measured by
/// Atoll's audit on that state, as for Atoll itself.

#include <atoll/scene.h>

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace peer {

struct BodyState {
  atl::Pose pose = {};
  atl::Vector3 velocity = atl::Vector3::Zero();          ///< m/s, world frame
  atl::Vector3 angular_velocity = atl::Vector3::Zero();  ///< rad/s, world frame
};

/// A scene in another engine.
class Simulation {
 public:
  Simulation() = default;
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;
  virtual ~Simulation() = default;

  virtual void step(double dt) = 0;
  virtual std::vector<BodyState> state() const = 0;  ///< in the order of the scene's bodies
};

struct Engine {
  std::string name;
  std::string version;
  std::string setting;  ///< in words: what the engine runs with
  /// Gets the bodies' masses too, as Atoll takes them from their definitions (kg, infinite where nothing moves
  /// them). Throws atl::Error on a scene that the engine or its driver has no equal for.
  std::function<std::unique_ptr<Simulation>(const atl::Scene&, std::span<const double> masses)> load;
};

/// A driver's main. Returns its exit status: 0, 2 on a wrong command line, 3 on an unusable scene, 4 on a
/// state that is not finite.
int run(const Engine& engine, int argc, char** argv);

}  // namespace peer
