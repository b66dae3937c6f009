#include <jobs/assert.h>
#include <solver/sweep/impact_contact.h>
#include <solver/tuning.h>

#include <algorithm>
#include <cmath>

namespace atl::solver {
namespace {

double length_of(double a, double b) { return std::sqrt(a * a + b * b); }

// The impulses on the two bodies of a contact.
ImpactMomentum on_first(const ImpactContact& contact, const Vector3& impulse, const Vector3& angular) {
  return {-impulse, -(contact.arm_first.cross(impulse) + angular)};
}
ImpactMomentum on_second(const ImpactContact& contact, const Vector3& impulse, const Vector3& angular) {
  return {impulse, contact.arm_second.cross(impulse) + angular};
}

// A contact with the bodies that it acts on.
struct Acting {
  ImpactContact& contact;
  ImpactBody& first;
  ImpactBody& second;
  const ImpactBodies& all;

  void apply(const Vector3& impulse, const Vector3& angular) const {
    if (first.is_joined()) {
      all.systems[first.system].push(first.place, on_first(contact, impulse, angular), all.bodies);
    } else {
      first.velocity -= first.inverse_mass.cwiseProduct(impulse);
      first.spin -= first.inverse_inertia * (contact.arm_first.cross(impulse) + angular);
    }
    if (second.is_joined()) {
      all.systems[second.system].push(second.place, on_second(contact, impulse, angular), all.bodies);
    } else {
      second.velocity += second.inverse_mass.cwiseProduct(impulse);
      second.spin += second.inverse_inertia * (contact.arm_second.cross(impulse) + angular);
    }
  }

  // Has bodies begin elsewhere: `back` seconds, below 0, of what the impulse makes of their velocities.
  void put_back(double back, const Vector3& impulse, const Vector3& angular) const {
    if (first.is_joined()) {
      all.systems[first.system].put_back(first.place, back, on_first(contact, impulse, angular));
    } else {
      first.shift -= back * first.inverse_mass.cwiseProduct(impulse);
      first.turn -= back * (first.inverse_inertia * (contact.arm_first.cross(impulse) + angular));
    }
    if (second.is_joined()) {
      all.systems[second.system].put_back(second.place, back, on_second(contact, impulse, angular));
    } else {
      second.shift += back * second.inverse_mass.cwiseProduct(impulse);
      second.turn += back * (second.inverse_inertia * (contact.arm_second.cross(impulse) + angular));
    }
  }

  // Slip along the tangents, and spin about the normal.
  std::array<double, 3> slip() const {
    const Vector3 velocity =
        second.velocity + second.spin.cross(contact.arm_second) - first.velocity - first.spin.cross(contact.arm_first);
    return {contact.axes[1].dot(velocity) + contact.friction.runs[0],
            contact.axes[2].dot(velocity) + contact.friction.runs[1],
            contact.axes[0].dot(second.spin - first.spin) + contact.friction.runs[2]};
  }

  double load() const {
    double sum = 0;
    for (const ImpactContact::Point& point : contact.points) sum += point.impulse;
    return sum;
  }

  // Each returns the largest change of a speed that it made, m/s.
  double push(ImpactContact::Point& point) const {
    if (!point.hits) return 0;
    const double wanted = point.mass * (point.parting - contact.parting_speed(point, first, second));
    const double impulse = std::max(wanted, -point.impulse);
    point.impulse += impulse;
    const auto& [normal, tangent, other] = contact.axes;
    apply(impulse * normal, impulse * (point.y * tangent - point.x * other));
    return point.mass > 0 ? std::abs(impulse) / point.mass : 0;
  }

  double rub(Friction friction) const {
    const double pushed = load();
    const double bound = contact.friction.coefficient * pushed;
    ATL_ASSERT(!(bound < 0), contact.block, contact.lane, bound);
    const std::array<double, 3> now = slip();
    const auto& [m11, m12, m22] = contact.friction.mass;
    std::array<double, 3>& impulse = contact.friction.impulse;
    const std::array<double, 3> before = impulse;
    impulse[0] -= m11 * now[0] + m12 * now[1];
    impulse[1] -= m12 * now[0] + m22 * now[1];
    const FrictionEllipse& ellipse = contact.friction.ellipse;
    if (!ellipse.is_disc()) {
      std::array<double, 2> along = {impulse[0], impulse[1]};
      if (friction == Friction::Pyramid) {
        ellipse.hold_in_rectangle(bound, along);
      } else {
        ellipse.hold(contact.friction.mass, bound, along);
      }
      std::copy(along.begin(), along.end(), impulse.begin());
    } else if (friction == Friction::Pyramid) {
      for (int axis : {0, 1}) impulse[axis] = std::clamp(impulse[axis], -bound, bound);
    } else if (length_of(impulse[0], impulse[1]) > bound) {
      // Alike in all directions, so that what comes of it acts against the slip.
      const double mean = 0.5 * (m11 + m22), spread = length_of(0.5 * (m11 - m22), m12);
      const double mass = mean - spread > 1e-6 * mean ? mean - spread : mean + spread;
      for (int axis : {0, 1}) impulse[axis] = before[axis] - mass * now[axis];
      const double length = length_of(impulse[0], impulse[1]);
      for (int axis : {0, 1}) impulse[axis] *= length > bound ? bound / length : 1;
    }
    // The axes of an ellipse are in single precision.
    ATL_ASSERT(friction == Friction::Pyramid || !(length_of(impulse[0], impulse[1]) > bound * (1 + 1e-6)),
               contact.block, contact.lane, impulse[0], impulse[1], bound);
    const double twist_bound = bound * contact.friction.radius + contact.friction.torsional * pushed;
    impulse[2] = std::clamp(impulse[2] - contact.friction.twist_mass * now[2], -twist_bound, twist_bound);
    apply((impulse[0] - before[0]) * contact.axes[1] + (impulse[1] - before[1]) * contact.axes[2],
          (impulse[2] - before[2]) * contact.axes[0]);
    const std::array<double, 3> then = slip();
    return std::max(std::abs(then[0] - now[0]), std::abs(then[1] - now[1]));
  }
};

// J: what impulses do to the energy is linear s + square s^2 if they are scaled by s; `given` is what normal ones add.
struct Work {
  double linear = 0, square = 0, given = 0;

  void add(double impulse, double before, double after) {
    linear += impulse * before;
    square += 0.5 * impulse * (after - before);
  }
};

// 1/kg: what a joined body adds to the motion along one direction by an impulse along another, by its own motion and
// by that of the other body if it is in the same system.
double response_of(const ImpactBodies& all, const ImpactBody& body, const ImpactMomentum& along,
                   const ImpactMomentum& impulse, const ImpactBody& other, const ImpactMomentum& impulse_on_other) {
  if (!body.is_joined()) {
    return along.linear.dot(body.inverse_mass.cwiseProduct(impulse.linear)) +
           along.angular.dot(body.inverse_inertia * impulse.angular);
  }
  const ImpactSystem& system = all.systems[body.system];
  const double own = system.response(body.place, along, body.place, impulse);
  if (other.system != body.system) return own;
  return own + system.response(body.place, along, other.place, impulse_on_other);
}

Work work_of(const ImpactEnd& end) {
  Work work;
  work.add(end.impulse, end.before, end.rate);
  return work;
}

Work work_of(const Acting& acting) {
  Work work;
  const ImpactContact& contact = acting.contact;
  for (const ImpactContact::Point& point : contact.points) {
    const double after = contact.parting_speed(point, acting.first, acting.second) + contact.pulled;
    const double before = point.closing + contact.pulled;
    work.add(point.impulse, before, after);
    work.given += std::max(0.5 * point.impulse * (before + point.parting + contact.pulled), 0.0);
  }
  const std::array<double, 3> after = acting.slip();
  for (std::size_t i = 0; i < 3; ++i) {
    // The speed against a surface that runs, since its motion drives the body.
    work.add(contact.friction.impulse[i], contact.friction.slip_before[i], after[i]);
    work.given += std::max(-contact.friction.impulse[i] * contact.friction.runs[i], 0.0);
  }
  return work;
}

}  // namespace

void weigh_joined(const ImpactBodies& all, ImpactContact& contact) {
  const ImpactBody& first = all.bodies[contact.first];
  const ImpactBody& second = all.bodies[contact.second];
  // An impulse along or about an axis of the contact, or one with a couple.
  struct Direction {
    Vector3 linear, angular;
  };
  const auto response = [&](const Direction& along, const Direction& by) {
    const ImpactMomentum along_first = on_first(contact, along.linear, along.angular);
    const ImpactMomentum along_second = on_second(contact, along.linear, along.angular);
    const ImpactMomentum by_first = on_first(contact, by.linear, by.angular);
    const ImpactMomentum by_second = on_second(contact, by.linear, by.angular);
    return response_of(all, first, along_first, by_first, second, by_second) +
           response_of(all, second, along_second, by_second, first, by_first);
  };
  const auto mass = [&](const Direction& along) {
    const double responds = response(along, along);
    return responds > 0 ? 1 / responds : 0;
  };
  const auto& [normal, tangent, other] = contact.axes;
  for (ImpactContact::Point& point : contact.points) {
    if (point.hits) point.mass = mass({normal, point.y * tangent - point.x * other});
  }
  const Direction one{tangent, Vector3::Zero()}, two{other, Vector3::Zero()};
  const double r11 = response(one, one), r12 = response(one, two), r22 = response(two, two);
  const double determinant = r11 * r22 - r12 * r12;
  if (determinant > 0) contact.friction.mass = {r22 / determinant, -r12 / determinant, r11 / determinant};
  contact.friction.twist_mass = mass({Vector3::Zero(), normal});
}

void reflect(std::span<ImpactContact> contacts, const ImpactBodies& bodies, std::span<const std::uint32_t> joined,
             Friction friction) {
  const auto each = [&](const auto& act) {
    for (ImpactContact& contact : contacts) {
      act(Acting{contact, bodies.bodies[contact.first], bodies.bodies[contact.second], bodies});
    }
  };
  const auto each_end = [&](const auto& act) {
    for (const std::uint32_t number : joined) {
      for (ImpactEnd& end : bodies.systems[number].ends()) act(bodies.systems[number], end);
    }
  };
  double speed = 0;
  each([&](const Acting& acting) {
    acting.contact.friction.slip_before = acting.slip();
    for (const ImpactContact::Point& point : acting.contact.points) {
      if (point.hits) speed = std::max(speed, -point.closing);
    }
  });
  for (int i = 0; i < tuning::max_impact_sweeps; ++i) {
    double change = 0;
    each([&](const Acting& acting) {
      for (ImpactContact::Point& point : acting.contact.points) change = std::max(change, acting.push(point));
      if (friction != Friction::None && acting.contact.friction.coefficient > 0)
        change = std::max(change, acting.rub(friction));
    });
    each_end([&](ImpactSystem& system, ImpactEnd& end) { change = std::max(change, system.push(end, bodies.bodies)); });
    if (change <= tuning::impact_tolerance * speed) break;
  }
  Work all;
  const auto add = [&](const Work& work) {
    all.linear += work.linear;
    all.square += work.square;
    all.given += work.given;
  };
  each([&](const Acting& acting) { add(work_of(acting)); });
  each_end([&](const ImpactSystem&, const ImpactEnd& end) { add(work_of(end)); });
  // linear s + square s^2 = wanted
  const double wanted = std::min(all.linear + all.square, all.given);
  const double root = all.linear * all.linear + 4 * all.square * wanted;
  const double scale = all.square > 0 && root > 0 ? (std::sqrt(root) - all.linear) / (2 * all.square) : 1;
  ATL_ASSERT(!(scale < 0), contacts.size(), all.linear, all.square, all.given);
  each([&](const Acting& acting) {
    ImpactContact& contact = acting.contact;
    const auto& [normal, tangent, other] = contact.axes;
    Vector3 impulse = contact.friction.impulse[0] * tangent + contact.friction.impulse[1] * other;
    Vector3 angular = contact.friction.impulse[2] * normal;
    for (ImpactContact::Point& point : contact.points) {
      impulse += point.impulse * normal;
      angular += point.impulse * (point.y * tangent - point.x * other);
      point.impulse *= scale;
    }
    acting.apply((scale - 1) * impulse, (scale - 1) * angular);
    acting.put_back(-scale * contact.time, impulse, angular);
    if (!(acting.load() > 0)) return;
    for (ImpactBody* body : {&acting.first, &acting.second}) body->changed |= body->moves();
  });
  each_end(
      [&](ImpactSystem& system, ImpactEnd& end) { system.add_impulse(end, (scale - 1) * end.impulse, bodies.bodies); });
}

}  // namespace atl::solver
