#include "step/contact_rules.h"

#include <features/with_restitution.h>
#include <features/with_surfaces.h>
#include <solver/integrate/state_bounds.h>

#include <algorithm>
#include <sstream>
#include <tuple>
#include <utility>

#include "step/results.h"
#include "world/bodies.h"
#include "world/colliders.h"
#include "world/left_out.h"
#include "world/refuse.h"

namespace atl {
namespace {

// Two colliders as users see them: the body of the lower index first.
struct Seen {
  collision::Pair pair;
  std::uint32_t a, b;  // bodies
  std::uint32_t child_a, child_b;
  std::uint32_t number;  // among those that are asked about

  auto order() const { return std::tuple(a, b, child_a, child_b, number); }
  bool operator<(const Seen& other) const { return order() < other.order(); }
};

Seen seen(const Stores& world, collision::Pair pair, std::size_t number) {
  std::uint32_t first = pair.first, second = pair.second;
  const std::span<const std::uint32_t> body = world.colliders.body;
  if (body[first] > body[second]) std::swap(first, second);
  return {pair,
          body[first],
          body[second],
          world.colliders.child[first],
          world.colliders.child[second],
          static_cast<std::uint32_t>(number)};
}

// Throws if a modifier left a value that a step can't work with.
void check(const ModifiableContact& contact, double restitution_before) {
  constexpr const char* call = "ContactModifier: contact.";
  check_not_negative((std::string(call) + "friction").c_str(), contact.friction);
  if (!(contact.restitution >= 0 && contact.restitution <= 1)) {
    std::ostringstream message;
    message << call << "restitution is " << contact.restitution << "; expected a number from 0 to 1";
    throw Error(message.str());
  }
  check_number((std::string(call) + "surface_velocity").c_str(), contact.surface_velocity, {0, solver::top_speed});
  check_built_for_surface((std::string(call) + "surface_velocity").c_str(), contact.surface_velocity);
  if (!with_restitution && contact.restitution > restitution_before) {
    throw_left_out("ContactModifier: contact.restitution is above 0", "bounces", "RESTITUTION");
  }
}

}  // namespace

void ContactRules::begin_step(const World& world) {
  world_ = &world;
  questions_ = 0;
  thrown_ = nullptr;
}

void ContactRules::rethrow() {
  if (thrown_) std::rethrow_exception(std::exchange(thrown_, nullptr));
}

// Calls a function of the user's unless one has thrown in this step. Whether it came to an answer.
template <typename Call>
bool ContactRules::call(const char* what, const Call& call) {
  if (thrown_) return false;
  asking_ = what;
  try {
    call();
  } catch (...) {
    thrown_ = std::current_exception();
  }
  asking_ = nullptr;
  return !thrown_;
}

template <typename Ask>
ContactAnswers ContactRules::answers(const Ask& ask) {
  const std::uint32_t question = questions_++;
  if (recorded.answer) return recorded.answer(question);
  ContactAnswers answers = ask();
  if (note && !answers.is_empty()) note(question, answers);
  return answers;
}

std::vector<collision::Pair> ContactRules::refuse(const Stores& world, std::span<const collision::Pair> pairs) {
  std::vector<Seen> order;
  const auto may_move = [&](std::uint32_t body) { return world.records.type[body] == BodyType::Dynamic; };
  for (const collision::Pair pair : pairs) {
    const Seen candidate = seen(world, pair, 0);
    if (may_move(candidate.a) || may_move(candidate.b)) order.push_back(candidate);
  }
  if (order.empty()) return {};
  std::sort(order.begin(), order.end());
  asked_pairs_ += static_cast<std::int64_t>(order.size());
  return answers([&] {
           ContactAnswers answers;
           for (const Seen& of : order) {
             bool may_touch = true;
             const ContactCandidate candidate{*world_, id_of(world, of.a), id_of(world, of.b), of.child_a, of.child_b};
             if (!call("a contact filter", [&] { may_touch = filter(candidate); })) break;
             if (!may_touch) answers.refused.push_back(of.pair);
           }
           std::sort(answers.refused.begin(), answers.refused.end());
           return answers;
         })
      .refused;
}

std::vector<ModifiedContact> ContactRules::modify(const Stores& world,
                                                  std::span<const collision::TouchingPair> contacts) {
  if (contacts.empty()) return {};
  asked_contacts_ += static_cast<std::int64_t>(contacts.size());
  const auto ask = [&] {
    // Parts of a pair come one after the other, so that their numbers are in their order.
    std::vector<Seen> order;
    order.reserve(contacts.size());
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      order.push_back(seen(world, world.cache.contacts[contacts[i].slot].pair, i));
    }
    std::sort(order.begin(), order.end());
    ContactAnswers answers;
    for (const Seen& of : order) {
      const collision::Contact& contact = world.cache.contacts[contacts[of.number].slot];
      const collision::ContactManifold& manifold = world.cache.manifolds[contacts[of.number].slot];
      const ManifoldPlace place = place_of(world, contact, manifold);
      const double side = contact.body_first == of.a ? 1 : -1;
      std::array<ModifiablePoint, collision::max_points> points;
      for (std::size_t i = 0; i < contact.count; ++i) {
        points[i] = {place.point(manifold, i), manifold.separation[i], contact.ids[i]};
      }
      ModifiableContact seen{.world = *world_,
                             .a = id_of(world, of.a),
                             .b = id_of(world, of.b),
                             .child_a = of.child_a,
                             .child_b = of.child_b,
                             .part = contact.part,
                             .normal = side * place.normal,
                             .points = std::span(points).first(contact.count),
                             .friction = manifold.friction,
                             .restitution = manifold.restitution};
      const bool answered = call("a contact modifier", [&] {
        modifier(seen);
        check(seen, static_cast<double>(manifold.restitution));
      });
      if (!answered) break;
      ModifiedContact modified{.pair = contact.pair,
                               .part = contact.part,
                               .friction = static_cast<float>(seen.friction + 0.0),  // -0 is 0
                               .restitution = static_cast<float>(seen.restitution + 0.0)};
      for (std::size_t i = 0; i < contact.count; ++i) {
        if (seen.enabled && points[i].enabled) modified.points |= static_cast<std::uint8_t>(1u << i);
      }
      for (std::size_t i = 0; i < 3; ++i) {
        modified.slip[i] = static_cast<float>(side * seen.surface_velocity[static_cast<Eigen::Index>(i)]);
      }
      const bool changed = modified.friction != manifold.friction || modified.restitution != manifold.restitution ||
                           modified.points != (1u << contact.count) - 1 || !seen.surface_velocity.isZero(0);
      if (changed) answers.modified.push_back(modified);
    }
    std::sort(answers.modified.begin(), answers.modified.end(), [](const ModifiedContact& x, const ModifiedContact& y) {
      return std::pair(x.pair, x.part) < std::pair(y.pair, y.part);
    });
    return answers;
  };
  return answers(ask).modified;
}

}  // namespace atl
