#pragma once

#include <atoll/contact_callbacks.h>
#include <atoll/world.h>
#include <collision/broadphase/pair.h>
#include <collision/contacts/touching_pair.h>

#include <array>
#include <cstdint>
#include <exception>
#include <functional>
#include <span>
#include <vector>

#include "world/stores.h"

namespace atl {

/// A contact that a modifier changed, as the solver sees it.
struct ModifiedContact {
  collision::Pair pair;  // colliders
  std::uint8_t part = 0;
  std::uint8_t points = 0;  // a bit each for those that are on
  float friction = 0;
  float restitution = 0;
  std::array<float, 3> slip = {};  // m/s, of the second collider's surface against the first's
};

/// Answers of a filter and a modifier to one question within a step.
struct ContactAnswers {
  std::vector<collision::Pair> refused;   // in order
  std::vector<ModifiedContact> modified;  // those that it changed, in order

  bool is_empty() const { return refused.empty() && modified.empty(); }
};

/// The contact filter and the contact modifier of a world: asks them, on the thread that steps, in the order that users
/// are promised. A replay has neither, but what they said.
class ContactRules {
 public:
  ContactFilter filter;
  ContactModifier modifier;

  /// Both get and give the number of the question in the step, from 0 on.
  struct Recorded {
    bool filters = false;
    bool modifies = false;
    std::function<ContactAnswers(std::uint32_t question)> answer;
  };
  /// For a replay: in place of the functions.
  Recorded recorded;
  /// Told of what isn't as if nobody had been asked; empty while nothing is recorded.
  std::function<void(std::uint32_t question, const ContactAnswers&)> note;

  bool filters() const { return recorded.answer ? recorded.filters : static_cast<bool>(filter); }
  bool modifies() const { return recorded.answer ? recorded.modifies : static_cast<bool>(modifier); }

  /// A step begins, of the world as its user knows it.
  void begin_step(const World& world);
  /// A substep of a force law does, or all of a step.
  void begin_substep() { asked_pairs_ = asked_contacts_ = 0; }
  /// Throws what a function threw in the step, once it is done.
  void rethrow();
  /// Names the function that is being asked, for messages; null if none is.
  const char* asking() const { return asking_; }

  /// Asks the filter: returns the pairs that may not touch, in order.
  std::vector<collision::Pair> refuse(const Stores& world, std::span<const collision::Pair> pairs);
  /// Asks the modifier: returns the contacts that it changed, in their order.
  std::vector<ModifiedContact> modify(const Stores& world, std::span<const collision::TouchingPair> contacts);

  /// In the substep so far.
  std::int64_t asked_pairs() const { return asked_pairs_; }
  std::int64_t asked_contacts() const { return asked_contacts_; }

 private:
  template <typename Ask>
  ContactAnswers answers(const Ask& ask);
  template <typename Call>
  bool call(const char* what, const Call& call);

  const World* world_ = nullptr;
  const char* asking_ = nullptr;
  std::uint32_t questions_ = 0;  // in the step so far
  std::exception_ptr thrown_;    // the first in the step: nobody is asked after it
  std::int64_t asked_pairs_ = 0;
  std::int64_t asked_contacts_ = 0;
};

}  // namespace atl
