// Self-convergence of scenes without a closed form: short pieces of a fine run, made again with fewer substeps.

#include <atoll/atoll.h>
#include <atoll/scene.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <iomanip>
#include <iostream>
#include <string>
#include <vector>

namespace {

struct Options {
  std::string scene;
  int steps = 0;  // 0: as many as the scene says
  int pieces = 4;
  double length = 0.2;  // s
  int fine = 64;
  int relax = 1;
  std::uint64_t seed = 1;
};

using States = std::vector<atl::BodyState>;

// The scene with a number of substeps, from given states where there are some.
class Run {
 public:
  Run(const atl::Scene& scene, int substeps, int relax, const States* start = nullptr)
      : scene_(scene), world_({.gravity = scene.gravity, .settings = with(scene.settings, substeps, relax)}) {
    ids_ = atl::build_scene(scene, world_);
    if (start == nullptr) return;
    for (std::size_t i = 0; i < ids_.size(); ++i) {
      if (world_.type(ids_[i]) == atl::BodyType::Static) continue;
      world_.set_pose(ids_[i], (*start)[i].pose);
      world_.set_velocity(ids_[i], (*start)[i].velocity, (*start)[i].angular_velocity);
    }
  }

  void step(int count) {
    for (int i = 0; i < count; ++i) {
      atl::apply_forces(scene_, world_, ids_);
      world_.step(scene_.dt);
    }
  }
  States states() const { return atl::body_states(world_, ids_); }

 private:
  static atl::Settings with(atl::Settings settings, int substeps, int relax) {
    settings.substeps = substeps;
    settings.relax_iterations = relax;
    return settings;
  }

  const atl::Scene& scene_;
  atl::World world_;
  std::vector<atl::BodyId> ids_;
};

struct Deviation {
  double position = 0;  // m, mean square until root() is taken
  double rotation = 0;  // rad

  Deviation root() const { return {std::sqrt(position), std::sqrt(rotation)}; }
};

// Mean squares over the dynamic bodies.
Deviation deviation(const atl::Scene& scene, const States& a, const States& b) {
  Deviation sum;
  double count = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (scene.bodies[i].def.type != atl::BodyType::Dynamic) continue;
    const double angle = a[i].pose.orientation.angularDistance(b[i].pose.orientation);
    sum.position += (a[i].pose.position - b[i].pose.position).squaredNorm();
    sum.rotation += angle * angle;
    ++count;
  }
  return {sum.position / count, sum.rotation / count};
}

// By how much halving the substep divides the deviation, as a power of two.
void print_order(double coarse, double fine) {
  std::cout << std::setw(8);
  if (coarse > 0 && fine > 0) {
    std::cout << std::fixed << std::setprecision(2) << std::log2(coarse / fine) << std::defaultfloat;
  } else {
    std::cout << '-';
  }
}

void run(const Options& options) {
  atl::Scene scene = atl::load_scene(options.scene, options.seed);
  if (options.steps > 0) scene.steps = options.steps;
  const int piece_steps = std::max(1, static_cast<int>(std::lround(options.length / scene.dt)));

  std::vector<int> substeps;
  for (int k = 1; k < options.fine; k *= 2) substeps.push_back(k);
  std::vector<Deviation> total(substeps.size());
  std::vector<std::vector<Deviation>> by_piece;

  Run fine(scene, options.fine, options.relax);
  int done = 0;
  for (int piece = 0; piece < options.pieces; ++piece) {
    const int start_step = piece * scene.steps / options.pieces;
    fine.step(start_step - done);
    done = start_step;
    const States start = fine.states();
    const auto piece_with = [&](int count) {
      Run part(scene, count, options.relax, &start);
      part.step(piece_steps);
      return part.states();
    };
    const States reference = piece_with(options.fine);
    std::vector<Deviation>& row = by_piece.emplace_back();
    for (std::size_t k = 0; k < substeps.size(); ++k) {
      const Deviation d = deviation(scene, piece_with(substeps[k]), reference);
      row.push_back(d.root());
      total[k].position += d.position / options.pieces;
      total[k].rotation += d.rotation / options.pieces;
    }
  }

  std::cout << options.scene << ": " << options.pieces << " pieces of " << piece_steps << " steps of " << scene.dt
            << " s, against " << options.fine << " substeps\n"
            << "substeps  RMS position m   order  RMS rotation rad   order   position m by piece\n";
  for (std::size_t k = 0; k < substeps.size(); ++k) {
    const Deviation all = total[k].root();
    const Deviation finer = k + 1 < substeps.size() ? total[k + 1].root() : Deviation{};
    std::cout << std::setw(8) << substeps[k] << std::setprecision(3) << std::setw(16) << all.position;
    print_order(all.position, finer.position);
    std::cout << std::setprecision(3) << std::setw(18) << all.rotation;
    print_order(all.rotation, finer.rotation);
    std::cout << "  " << std::setprecision(2);
    for (const std::vector<Deviation>& piece : by_piece) std::cout << ' ' << std::setw(9) << piece[k].position;
    std::cout << '\n';
  }
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app(
      "Starts short pieces from states of a fine run, with 1, 2, 4, ... substeps, each in a fresh world, and "
      "prints how far they end from the same piece at the finest, and the order of convergence.");
  app.add_option("SCENE", options.scene, "scene file or built-in scene")->required();
  app.add_option("--steps", options.steps, "steps of the fine run (default: the scene's)")
      ->check(CLI::Range(1, 1'000'000));
  app.add_option("--pieces", options.pieces, "pieces, which start at equal distances")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--length", options.length, "length of a piece, s")
      ->check(CLI::Range(0.001, 10.0))
      ->capture_default_str();
  app.add_option("--fine", options.fine, "substeps of the fine run, a power of two")
      ->check(CLI::Range(2, 1024))
      ->capture_default_str();
  app.add_option("--relax", options.relax, "relaxing sweeps of all runs")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  app.add_option("--seed", options.seed, "seed of a scene's random content")->capture_default_str();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    run(options);
  } catch (const atl::Error& error) {
    std::cerr << "atoll_convergence: " << error.what() << '\n';
    return 3;
  }
  return 0;
}
