// How often contact forces well above the mean occur in a bed of balls, by discrete elements: springs and dashpots
// along the normal and, with a memory, across it (Cundall and Strack, Geotechnique 29, 1979). It shares nothing with
// the engine, and gives the physics case `force-tail` what is right for its bed.

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace {

using Vector = Eigen::Vector3d;

constexpr double g = 9.81;        // m/s^2
constexpr double d = 1;           // m, balls on average
constexpr double width = 10 * d;  // of the shaft
constexpr double friction = 0.5;  // of all
constexpr double bounce = 0.3;    // coefficient of restitution
constexpr double pi = 3.14159265358979323846;
constexpr double skin = 0.06 * d;  // how far apart pairs are looked for

// The floor and the four walls.
struct Wall {
  Vector normal;
  double offset;
};
const Wall walls[] = {{Vector::UnitX(), -width / 2},
                      {-Vector::UnitX(), -width / 2},
                      {Vector::UnitY(), -width / 2},
                      {-Vector::UnitY(), -width / 2},
                      {Vector::UnitZ(), 0}};

struct Ball {
  Vector place = Vector::Zero(), velocity = Vector::Zero(), spin = Vector::Zero();
  double radius = 0, mass = 0;
  Vector force = Vector::Zero(), torque = Vector::Zero();
  Vector at_walls[5] = {Vector::Zero(), Vector::Zero(), Vector::Zero(), Vector::Zero(), Vector::Zero()};
};

struct Pair {
  std::size_t first, second;
  Vector slip;  // m, of the spring across
};

struct Force {
  double newton;
  double height;
};

class Bed {
 public:
  // `stiffness`: of the springs, in weights of a ball by its diameter.
  Bed(int count, double stiffness) {
    const double mass = ball_mass(d / 2);
    normal_stiffness_ = stiffness * mass * g / d;
    step_ = 0.06 * std::sqrt(mass / 2 / normal_stiffness_);
    std::mt19937 random(1);
    std::uniform_real_distribution<double> uniform(0, 1);
    const double pitch = 1.15 * d;
    const int along = static_cast<int>(width / pitch);
    const Vector lowest(-0.5 * pitch * (along - 1), -0.5 * pitch * (along - 1), 0.7 * d);
    for (int i = 0; i < count; ++i) {
      Ball ball;
      ball.place = lowest + pitch * Vector(i % along, i / along % along, i / (along * along));
      ball.radius = d * (0.45 + 0.1 * uniform(random));
      ball.mass = ball_mass(ball.radius);
      const double vx = uniform(random) - 0.5, vy = uniform(random) - 0.5;
      ball.velocity = {vx, vy, 0};
      balls_.push_back(ball);
    }
  }

  // Lets all fall and come to rest.
  std::vector<Force> settle(double seconds) {
    std::vector<Force> forces;
    for (double time = 0; time < seconds; time += step_) {
      find_pairs();
      forces.clear();
      add_forces(forces);
      for (Ball& ball : balls_) {
        ball.velocity += step_ / ball.mass * ball.force;
        ball.spin += step_ / (0.4 * ball.mass * ball.radius * ball.radius) * ball.torque;
        ball.place += step_ * ball.velocity;
      }
    }
    return forces;
  }

 private:
  static double ball_mass(double radius) { return 4.0 / 3 * pi * radius * radius * radius; }

  void find_pairs() {
    double moved = looked_.empty() ? 1e30 : 0;
    for (std::size_t i = 0; i < looked_.size(); ++i) {
      moved = std::max(moved, (balls_[i].place - looked_[i]).norm());
    }
    if (moved < skin / 2) return;
    std::map<std::pair<std::size_t, std::size_t>, Vector> slips;
    for (const Pair& pair : pairs_) slips[{pair.first, pair.second}] = pair.slip;
    pairs_.clear();
    looked_.clear();
    for (const Ball& ball : balls_) looked_.push_back(ball.place);
    // Neighbours along z.
    std::vector<std::size_t> order(balls_.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::sort(order.begin(), order.end(),
              [&](std::size_t a, std::size_t b) { return looked_[a].z() < looked_[b].z(); });
    for (std::size_t i = 0; i < order.size(); ++i) {
      for (std::size_t j = i + 1; j < order.size(); ++j) {
        const std::size_t first = std::min(order[i], order[j]), second = std::max(order[i], order[j]);
        const Vector apart = looked_[second] - looked_[first];
        if (std::abs(apart.z()) > 1.1 * d + skin) break;
        if (apart.norm() > balls_[first].radius + balls_[second].radius + skin) continue;
        const auto known = slips.find({first, second});
        pairs_.push_back({first, second, known == slips.end() ? Vector(Vector::Zero()) : known->second});
      }
    }
  }

  void add_forces(std::vector<Force>& forces) {
    for (Ball& ball : balls_) {
      ball.force = {0, 0, -ball.mass * g};
      ball.torque.setZero();
    }
    for (Pair& pair : pairs_) {
      Ball& first = balls_[pair.first];
      Ball& second = balls_[pair.second];
      const Vector apart = second.place - first.place;
      const double distance = apart.norm();
      const Vector normal = apart / distance;
      const double force = push(first, &second, normal, distance - first.radius - second.radius, pair.slip);
      if (force > 0) forces.push_back({force, (first.place + first.radius * normal).z()});
    }
    for (Ball& ball : balls_) {
      for (std::size_t i = 0; i < std::size(walls); ++i) {
        const double gap = walls[i].normal.dot(ball.place) - walls[i].offset - ball.radius;
        const double force = push(ball, nullptr, -walls[i].normal, gap, ball.at_walls[i]);
        if (force > 0) forces.push_back({force, (ball.place - ball.radius * walls[i].normal).z()});
      }
    }
  }

  // The normal from the ball to what it touches, a wall if `other` is none; returns the force along it.
  double push(Ball& ball, Ball* other, const Vector& normal, double gap, Vector& slip) const {
    if (gap >= 0) {
      slip.setZero();
      return 0;
    }
    const double mass = other == nullptr ? ball.mass : ball.mass * other->mass / (ball.mass + other->mass);
    const double across_stiffness = 2.0 / 7 * normal_stiffness_;
    Vector speed = -ball.velocity - ball.radius * ball.spin.cross(normal);
    if (other != nullptr) speed += other->velocity - other->radius * other->spin.cross(normal);
    const double closing = speed.dot(normal);
    const double along =
        std::max(-normal_stiffness_ * gap - 2 * damping_ * std::sqrt(mass * normal_stiffness_) * closing, 0.0);

    const Vector sliding = speed - closing * normal;
    slip += step_ * sliding - slip.dot(normal) * normal;
    Vector across = -across_stiffness * slip - 2 * damping_ * std::sqrt(2.0 / 7 * mass * across_stiffness) * sliding;
    if (const double size = across.norm(); size > friction * along) {
      across *= friction * along / size;
      slip = -across / across_stiffness;
    }
    ball.force -= along * normal + across;
    ball.torque -= ball.radius * normal.cross(across);
    if (other != nullptr) {
      other->force += along * normal + across;
      other->torque -= other->radius * normal.cross(across);
    }
    return along;
  }

  double normal_stiffness_, step_;
  const double damping_ = -std::log(bounce) / std::sqrt(pi * pi + std::log(bounce) * std::log(bounce));  // ratio
  std::vector<Ball> balls_;
  std::vector<Pair> pairs_;
  std::vector<Vector> looked_;
};

// Decay rate of the exponential tail of the force distribution: forces are divided by the mean of their layer, and the
// rate is that of the maximum likelihood above 1.5 times this mean.
double tail(const std::vector<Force>& forces) {
  constexpr int lowest = 2, highest = 8;
  constexpr double from = 1.5;
  double above = 0, excess = 0;
  for (int layer = lowest; layer < highest; ++layer) {
    const auto lies = [&](const Force& force) { return static_cast<int>(force.height / d) == layer; };
    double sum = 0;
    int count = 0;
    for (const Force& force : forces) {
      if (!lies(force)) continue;
      sum += force.newton;
      ++count;
    }
    for (const Force& force : forces) {
      const double part = force.newton * count / sum;
      if (!lies(force) || part <= from) continue;
      above += 1;
      excess += part - from;
    }
  }
  return above / excess;
}

}  // namespace

int main(int count, char** words) {
  const double stiffness = count > 1 ? std::stod(words[1]) : 2e4;
  double sum = 0;
  const std::vector<int> fills = {1400, 1450, 1500, 1550, 1600};
  for (const int balls : fills) {
    const double found = tail(Bed(balls, stiffness).settle(50 * std::sqrt(d / g)));
    std::printf("%d balls: exp(-%.2f f)\n", balls, found);
    sum += found;
  }
  std::printf("mean: %.2f\n", sum / static_cast<double>(fills.size()));
}
