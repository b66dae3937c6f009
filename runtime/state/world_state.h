#pragma once
/// The state of a world, part by part: all that its future depends on beside the world definition, described once for
/// those who write, read and hash it. What follows from it is made anew after it was read: see restore.cpp. Whoever
/// adds something that lasts from step to step adds it here: the lists of members below don't compile until it is
/// named.

#include <features/with_direct_contacts.h>
#include <features/with_joints.h>
#include <features/with_surfaces.h>
#include <jobs/prefetch.h>
#include <jobs/scratch.h>
#include <solver/constraints/surface_contact.h>
#include <solver/integrate/motion_locks.h>
#include <solver/integrate/state_bounds.h>
#include <solver/tuning.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <type_traits>
#include <utility>
#include <vector>

#include "state/contact_state.h"
#include "state/filter_state.h"
#include "state/geometry_state.h"
#include "state/joint_state.h"
#include "state/restore.h"
#include "state/settings_state.h"
#include "state/state_archive.h"
#include "state/world_definition_state.h"
#include "world/bodies.h"
#include "world/materials.h"
#include "world/settings_check.h"
#include "world/stores.h"

namespace atl {

template <typename Archive>
void visit_finding(Archive& archive, solver::SolverSelection::Finding& finding) {
  visit_all(archive, finding.mode, finding.swept, finding.bodies);
  const bool by_load = finding.mode == solver::SolveMode::Sweep || finding.mode == solver::SolveMode::Refined ||
                       finding.mode == solver::SolveMode::Direct;
  archive.check(by_load && finding.swept >= 0 && std::isfinite(finding.swept), "a way to solve islands that is none");
}

template <typename Archive>
void visit_history(Archive& archive, solver::SubstepControl::History& history) {
  visit_all(archive, history.substeps, history.max, history.asked, history.needed, history.looked_at, history.hold,
            history.unchanged, history.lowered);
  constexpr int max = 1024;
  const auto is_time = [](float time) { return time >= 0 && std::isfinite(time); };
  archive.check(history.substeps <= max && history.max <= max && history.asked <= max &&
                    history.needed <= solver::max_needed_substeps && is_time(history.looked_at) &&
                    is_time(history.hold) && is_time(history.unchanged),
                "substeps of an island that can't be");
}

/// Visits the numbers below `count` for which stands_out() is true: visit(number) handles one.
template <typename Archive, typename StandsOut, typename Visit>
void visit_some(Archive& archive, std::size_t count, const StandsOut& stands_out, const Visit& visit) {
  std::uint32_t some = 0;
  if constexpr (Archive::reads) {
    some = archive.count_of(sizeof(std::uint32_t));
    std::uint32_t next = 0;
    for (std::uint32_t i = 0; i < some; ++i) {
      std::uint32_t number = 0;
      archive.value(number);
      archive.check(number >= next && number < count, "numbers out of order, or of things that there are not");
      next = number + 1;
      visit(number);
    }
  } else {
    for (std::uint32_t number = 0; number < count; ++number) some += stands_out(number) ? 1 : 0;
    archive.value(some);
    for (std::uint32_t number = 0; number < count && some > 0; ++number) {
      if (!stands_out(number)) continue;
      --some;
      archive.value(number);
      visit(number);
    }
  }
}

/// Ids of bodies, two by two; all indices are below `bodies`.
template <typename Archive, typename Pairs>
void visit_id_pairs(Archive& archive, Pairs& pairs, std::size_t bodies) {
  if constexpr (Archive::reads) {
    pairs.resize(archive.count_of(sizeof(std::pair<BodyId, BodyId>)));
  } else {
    archive.value(static_cast<std::uint32_t>(pairs.size()));
  }
  for (auto& [first, second] : pairs) {
    for (auto* id : {&first, &second}) {
      visit_value(archive, *id);
      archive.check(id->index < bodies, "the number of a body that there can't be");
    }
  }
  if constexpr (Archive::reads) {
    archive.check(std::adjacent_find(pairs.begin(), pairs.end(), std::greater_equal<>()) == pairs.end(),
                  "pairs of bodies that are not in order");
  }
}

template <typename Archive, typename Pair>
void visit_pair(Archive& archive, Pair& pair) {
  visit_all(archive, pair.first, pair.second);
}

/// Forces or torques, of which a world that nobody pushes has none.
template <typename Archive, typename Rows>
void visit_pushes(Archive& archive, Rows& rows, std::size_t bodies) {
  constexpr std::array<double, 3> zero = {0, 0, 0};
  if (!rows.empty()) return archive.template rows<3>(rows, zero);
  // Kept by the thread, so that nothing is allocated.
  struct Memory {
    std::remove_const_t<Rows> none;
  };
  auto& none = jobs::of_this_thread<Memory>().none;
  none.assign(3 * bodies, 0.0);
  archive.template rows<3>(none, zero);
  if constexpr (Archive::reads) {
    const auto pushes = [](double x) { return x != 0 || std::signbit(x); };
    if (std::any_of(none.begin(), none.end(), pushes)) rows = none;
  }
}

/// Pairs that a contact filter refused, and bodies of which it is to be asked again. Contacts go before.
template <typename Archive, typename AnyWorld>
void visit_choices(Archive& archive, AnyWorld& world) {
  auto& choices = world.choices;
  if (Archive::hashes && choices.is_empty()) return;
  if constexpr (Archive::reads) {
    choices.refused.resize(archive.count_of(sizeof(collision::Pair)));
  } else {
    archive.value(static_cast<std::uint32_t>(choices.refused.size()));
  }
  collision::Pair before = {};
  for (auto& pair : choices.refused) {
    visit_pair(archive, pair);
    archive.check(may_touch(world, pair) && before < pair && !world.cache.pairs.contains(pair),
                  "a refused pair that can't be");
    before = pair;
  }
  archive.list(choices.refiltered);
  std::uint32_t next = 0;
  for (const std::uint32_t body : choices.refiltered) {
    archive.check(body >= next && body < world.bodies.size() && world.records.alive[body],
                  "the number of a body that there is not");
    next = body + 1;
  }
}

/// Checks the poses of a state from a file, including those of bodies in quarantine or suspected by the next step.
template <typename Archive>
void check_poses(Archive& archive, const Stores& world) {
  const solver::BodyTable& bodies = world.bodies;
  for (std::uint32_t body = 0; body < bodies.size(); ++body) {
    if (!world.records.alive[body]) continue;
    archive.check_number(std::abs(bodies.orientation(body).squaredNorm() - 1) < 1e-9, "an orientation that is none");
    archive.check_number(bodies.turned[body] >= 0 || world.quarantine.contains(body), "a turn that is none");
    archive.check_number(world.aabbs.swept_margins()[body] >= 0, "a margin that is none");
    const bool is_finite = bodies.position(body).allFinite() && bodies.velocity(body).allFinite() &&
                           bodies.angular_velocity(body).allFinite();
    archive.check_number(is_finite, "a body whose state is not finite");
    const unsigned free = ~unsigned{bodies.locks[body]};
    const bool keeps_locks = bodies.locks[body] == 0 || world.quarantine.contains(body) ||
                             (solver::without(free, bodies.velocity(body)).isZero(0) &&
                              solver::without(free >> 3u, bodies.angular_velocity(body)).isZero(0));
    archive.check_number(keeps_locks, "a body that moves along an axis that is locked");
  }
}

/// Measured errors of islands, if there are error targets. Bodies go before.
template <typename Archive, typename AnyWorld>
void visit_control(Archive& archive, AnyWorld& world) {
  using History = solver::SubstepControl::History;
  const Settings& settings = world.settings;
  auto& control = world.control;
  if (Archive::hashes && !settings.target.is_set()) return;
  // Steps take turns to measure residuals. Their number is part of a state, if not of its hash.
  if (Archive::hashes && settings.target.residual) {
    std::int64_t turn = world.clock.steps % solver::tuning::residual_interval;
    archive.value(turn);
  }
  if constexpr (Archive::reads) control.forget_all();
  const std::size_t bodies = world.bodies.size();
  const auto check_body = [&](std::uint32_t body) {
    archive.check(body < bodies && world.records.alive[body], "the number of a body that there is not");
  };
  const auto has_history = [&control](std::uint32_t body) { return control.history(body) != History{}; };
  visit_some(archive, control.is_empty() && !Archive::reads ? 0 : bodies, has_history, [&](std::uint32_t body) {
    check_body(body);
    History history = control.history(body);
    visit_history(archive, history);
    if constexpr (Archive::reads) control.restore_history(body, bodies, history);
  });
  const auto is_known = [&control](std::uint32_t body) { return control.motion().is_known(body); };
  visit_some(archive, control.motion().is_empty() && !Archive::reads ? 0 : bodies, is_known, [&](std::uint32_t body) {
    check_body(body);
    solver::MotionError::Acceleration acceleration = {};
    if constexpr (!Archive::reads) acceleration = control.motion().acceleration(body);
    visit_value(archive, acceleration);
    if constexpr (Archive::reads) {
      archive.check(std::all_of(acceleration.begin(), acceleration.end(), [](float x) { return std::isfinite(x); }),
                    "an acceleration that is not finite");
      control.motion().restore(body, bodies, acceleration);
    }
  });
}

/// Bodies that World::set_enabled() took out.
template <typename Archive, typename AnyWorld, typename CheckBody>
void visit_disabled(Archive& archive, AnyWorld& world, const CheckBody& check_body) {
  const auto is_disabled = [&](std::uint32_t body) { return world.quarantine.is_disabled(body); };
  visit_some(archive, world.bodies.size(), is_disabled, [&](std::uint32_t body) {
    check_body(body);
    archive.check(world.sleeping.ring[body] == Sleeping::none && !world.quarantine.contains(body),
                  "a disabled body that sleeps or is in quarantine");
    if constexpr (Archive::reads) restore_disabled(world, body);
  });
}

/// Who fell asleep or woke since events were reported.
template <typename Archive, typename AnySleeping, typename CheckBody>
void visit_sleep_news(Archive& archive, AnySleeping& sleeping, std::size_t bodies, const CheckBody& check_body) {
  const std::vector<std::uint32_t> news = Archive::reads ? std::vector<std::uint32_t>() : sleeping.news();
  if constexpr (Archive::reads) {
    sleeping.unreported.clear();
    for (std::uint32_t body = 0; body < bodies; ++body) sleeping.mark_reported(body);
  }
  const auto is_new = [&](std::uint32_t body) { return std::binary_search(news.begin(), news.end(), body); };
  visit_some(archive, news.empty() && !Archive::reads ? 0 : bodies, is_new, [&](std::uint32_t body) {
    check_body(body);
    if constexpr (Archive::reads) {
      sleeping.unreported.push_back(body);
      sleeping.reported_asleep[body] ^= 1;
    }
  });
}

template <typename Archive, typename AnyWorld>
void visit_material_pairs(Archive& archive, AnyWorld& world) {
  if (Archive::hashes && world.material_pairs.empty()) return;
  const auto visit = [&](auto& pairs) {
    visit_each(archive, pairs, 2 * sizeof(std::uint64_t), [&](auto& pair) { visit_material_pair(archive, pair); });
  };
  if constexpr (Archive::reads) {
    std::vector<MaterialPair> pairs;
    visit(pairs);
    restore_material_pairs(world, std::move(pairs));
  } else {
    visit(world.material_pairs);
  }
}

/// `AnyWorld` is Stores, const where the archive doesn't read. Before a state is read the world has its world
/// definition.
template <typename Archive, typename AnyWorld>
class WorldState {
 public:
  WorldState(Archive& archive, AnyWorld& world) : archive_(archive), world_(world) {}

  void visit() {
    check_members();
    if constexpr (reads) apart_before_ = pairs_kept_apart(world_);
    visit_globals();
    visit_bodies();
    visit_surfaces();
    visit_material_pairs(archive_, world_);
    visit_sleeping();
    visit_quarantine();
    visit_selection();
    visit_control(archive_, world_);
    visit_events();
    visit_joints();
    visit_kept_apart();
    visit_boxes();
    visit_contacts();
    visit_choices(archive_, world_);
  }

  // The parts that body_hash.cpp tells by body.

  // Returns true if the world has the same joint.
  bool visit_one_joint(std::uint32_t index) {
    auto& joints = world_.joints;
    bool same = true;
    if constexpr (reads) {
      same = archive_.skip_if_same(definition_bytes(*world_.joints.def[index], definition_bytes_));
      if (!same) {
        JointDef def;
        visit_definition(archive_, def);
        restore_joint(world_, index, def);
      }
    } else {
      visit_definition(archive_, *joints.def[index]);
    }
    const auto enabled = joints.enabled[index];
    visit_all(archive_, joints.enabled[index], joints.broken[index]);
    archive_.check(joints.enabled[index] <= 1 && joints.broken[index] <= 1, "a flag that is neither 0 nor 1");
    archive_.check(!(joints.enabled[index] && joints.broken[index]), "a joint that is broken and enabled");
    visit_joint(archive_, joints.joints[index], joints.limit_before[index]);
    return same && enabled == joints.enabled[index];
  }

  void visit_one_contact(std::uint32_t slot) {
    auto& contact = world_.cache.contacts[slot];
    auto& manifold = world_.cache.manifolds[slot];
    auto* surface = slot < world_.surface_contacts.size() ? &world_.surface_contacts[slot] : nullptr;
    auto* rolling = surface != nullptr ? surface->rolling_impulse : nullptr;
    if constexpr (!reads) {
      if (rolling != nullptr) {
        const bool counts =
            solver::has_impulse(manifold) && std::any_of(rolling, rolling + 3, [](float x) { return x != 0; });
        if (!counts) rolling = nullptr;
      }
    }
    visit_contact(archive_, contact, manifold, rolling);
    if constexpr (reads) {
      if (world_.contents.own_materials > 0) mix_materials(world_, slot);
    }
  }

 private:
  static constexpr bool reads = Archive::reads;

  std::size_t body_count() const { return world_.bodies.size(); }
  bool is_body(std::uint32_t body) const { return body < body_count() && world_.records.alive[body] != 0; }

  void check_body(std::uint32_t body) { archive_.check(is_body(body), "the number of a body that there is not"); }

  void visit_globals() {
    if constexpr (reads) {
      Settings settings = world_.settings;
      visit_settings(archive_, settings);
      check(settings);
      world_.changes.joints |= settings.joint_solver != world_.settings.joint_solver;
      world_.settings = settings;
    } else {
      visit_settings(archive_, world_.settings);
    }
    visit_value(archive_, world_.gravity);
    archive_.check(world_.gravity.allFinite(), "gravity that is not finite");
    archive_.value(world_.clock.last_dt);
    archive_.check(world_.clock.last_dt >= 0 && world_.clock.last_dt <= 1, "a step of no valid duration");
    archive_.value(world_.results.contact_events.reported);
    // These values serve reports only, so the hash leaves them out.
    if constexpr (!Archive::hashes) {
      visit_all(archive_, world_.clock.last_substep, world_.clock.steps, world_.clock.time);
      archive_.check(world_.clock.time >= 0 && std::isfinite(world_.clock.time), "a time that is none");
    }
  }

  void visit_bodies() {
    constexpr std::array<double, 3> zero = {0, 0, 0};
    auto& bodies = world_.bodies;
    archive_.template rows<3>(bodies.positions, zero);
    archive_.template rows<4>(bodies.orientations, {0, 0, 0, 1});
    archive_.template rows<3>(bodies.velocities, zero);
    archive_.template rows<3>(bodies.angular_velocities, zero);
    visit_pushes(archive_, bodies.forces, body_count());
    visit_pushes(archive_, bodies.torques, body_count());
    archive_.template rows<1>(bodies.turned, {0});
    archive_.template rows<1>(world_.aabbs.bounds.aabb_margin, {0});
    archive_.template rows<1>(world_.aabbs.swept_margins(), {0});
    archive_.bits(world_.aabbs.bounds.aabb_dirty);
    // Nothing follows from it.
    if constexpr (!Archive::hashes) {
      archive_.template rows<1>(world_.records.user_data, {0});
      visit_names();
    }
  }

  void visit_names() {
    auto& names = world_.records.names;
    if constexpr (reads) {
      auto next = names.begin();  // those that stay keep their place
      const auto visit = [&](std::uint32_t body) {
        check_body(body);
        while (next != names.end() && next->first < body) next = names.erase(next);
        if (next == names.end() || next->first != body) next = names.emplace_hint(next, body, std::string());
        visit_text(archive_, next->second);
        ++next;
      };
      visit_some(
          archive_, body_count(), [](std::uint32_t) { return true; }, visit);
      names.erase(next, names.end());
    } else {
      archive_.value(static_cast<std::uint32_t>(names.size()));
      for (const auto& [body, name] : names) {
        archive_.value(body);
        visit_text(archive_, name);
      }
    }
  }

  // How fast they run: what holds back rolling is the material's.
  void visit_surfaces() {
    if constexpr (reads) restore_materials(world_);
    const auto runs = [this](std::uint32_t body) { return is_body(body) && !surface_motion(world_, body).is_zero(); };
    visit_some(archive_, body_count(), runs, [this](std::uint32_t body) {
      check_body(body);
      archive_.check(with_surfaces, "a surface that runs, which this build is without");
      solver::SurfaceMotion motion;
      if constexpr (!reads) motion = surface_motion(world_, body);
      archive_.values(motion.velocity.data(), 3);
      if (!Archive::hashes || !motion.angular_velocity.isZero(0)) archive_.values(motion.angular_velocity.data(), 3);
      if constexpr (reads) run_surface(world_, body, motion);
    });
    if constexpr (Archive::hashes) {
      for (std::uint32_t body = 0; body < world_.bodies.surfaces.size(); ++body) {
        const solver::Surface& surface = world_.bodies.surfaces[body];
        if (!is_body(body) || (surface.rolling_friction == 0 && surface.torsional_friction == 0)) continue;
        visit_all(archive_, body, surface.rolling_friction, surface.torsional_friction);
      }
    }
  }

  void visit_sleeping() {
    auto& sleeping = world_.sleeping;
    archive_.template rows<1>(sleeping.rest_time, {0});
    archive_.template rows<1>(sleeping.ring, {Sleeping::none});
    if constexpr (reads) check_rings();
    if constexpr (!Archive::hashes) {
      visit_sleep_news(archive_, world_.sleeping, body_count(), [this](std::uint32_t body) { check_body(body); });
    }
  }
  // Each sleeper is dynamic, and the next of just one.
  void check_rings() {
    const std::span<const std::uint32_t> ring = world_.sleeping.ring;
    std::vector<std::uint8_t> followed(body_count(), 0);
    for (std::uint32_t body = 0; body < body_count(); ++body) {
      const std::uint32_t next = ring[body];
      if (next == Sleeping::none) continue;
      const bool fits = is_body(body) && world_.records.type[body] == BodyType::Dynamic && next < body_count() &&
                        ring[next] != Sleeping::none && !followed[next];
      archive_.check(fits, "bodies that sleep without an island");
      followed[next] = 1;
    }
  }

  void visit_quarantine() {
    auto& list = world_.quarantine;
    if constexpr (reads) list.clear();
    const auto is_out = [&list](std::uint32_t body) { return list.is_quarantined(body); };
    visit_some(archive_, list.bodies().empty() && !reads ? 0 : body_count(), is_out, [&](std::uint32_t body) {
      check_body(body);
      archive_.check(world_.sleeping.ring[body] == Sleeping::none, "a body in quarantine that sleeps");
      Quarantine reason = {};
      std::int64_t step = 0;
      if constexpr (!reads) {
        reason = list.entry(body).reason;
        step = list.entry(body).step;
      }
      archive_.value(reason);
      archive_.check(reason >= Quarantine::NotFinite && reason <= Quarantine::TooMuchTorque,
                     "no reason for quarantine");
      archive_.value(step);
      if constexpr (reads) restore_quarantined(world_, body, reason, step);
    });
    if (!Archive::hashes || !list.disabled().empty()) {
      visit_disabled(archive_, world_, [this](std::uint32_t body) { check_body(body); });
    }
    const auto is_suspect = [&list](std::uint32_t body) { return list.is_suspect(body); };
    visit_some(archive_, body_count(), is_suspect, [&](std::uint32_t body) {
      if constexpr (reads) list.suspect(body);
    });
    if constexpr (reads) check_poses(archive_, world_);
    const auto strays = [&list](std::uint32_t body) { return list.pose_before(body) != nullptr; };
    visit_some(archive_, list.remembers_poses() || reads ? body_count() : 0, strays, [&](std::uint32_t body) {
      solver::BodyPose pose;
      if constexpr (!reads) pose = *list.pose_before(body);
      visit_value(archive_, pose);
      if constexpr (reads) {
        archive_.check_number(solver::is_in_place(pose.position, pose.orientation),
                              "a pose to go back to that is none");
        list.remember_pose(body, pose);
      }
    });
    if constexpr (reads) update_restored_bodies(world_);
  }

  void visit_selection() {
    using Finding = solver::SolverSelection::Finding;
    auto& selection = world_.selection;
    if constexpr (reads) selection.forget_all();
    const auto is_found = [&selection](std::uint32_t body) { return selection.finding(body) != Finding{}; };
    visit_some(archive_, body_count(), is_found, [&](std::uint32_t body) {
      check_body(body);
      archive_.check(with_direct_contacts, "overloaded contacts, which this build does nothing about");
      Finding finding = selection.finding(body);
      visit_finding(archive_, finding);
      if constexpr (reads) selection.restore(body, finding);
    });
  }

  void visit_events() {
    visit_id_pairs(archive_, world_.results.contact_events.touched, body_count());
    if (Archive::hashes && world_.contents.sensors == 0) return;
    visit_id_pairs(archive_, world_.results.sensor_events.within, body_count());
  }

  void visit_joints() {
    auto& joints = world_.joints;
    auto count = static_cast<std::uint32_t>(joints.size());
    [[maybe_unused]] bool same = true;  // as those that the world has
    if constexpr (reads) {
      count = archive_.count_of(1);
      same = count == joints.size();
      if (with_joints && !same) joints.reset(count);
    } else {
      archive_.value(count);
    }
    if constexpr (!with_joints) {
      archive_.check(count == 0, "joints, which this build is without");
    } else {
      if (count > 0) same &= visit_joint_table(count);
      if constexpr (reads) restore_joints(world_, same);
    }
  }
  // Returns true if the world has the same joints.
  bool visit_joint_table(std::uint32_t count) {
    auto& joints = world_.joints;
    bool same = true;
    if constexpr (reads) {
      jobs::CompactArray<std::uint8_t> alive(count);
      archive_.bits(alive);
      same = alive == joints.alive;
      joints.alive = std::move(alive);
    } else {
      archive_.bits(joints.alive);
    }
    archive_.template rows<1>(joints.generation, {0});
    archive_.list(joints.free);
    if constexpr (reads) check_free_joints();
    for (std::uint32_t joint = 0; joint < count; ++joint) {
      if (joints.alive[joint]) same &= visit_one_joint(joint);
    }
    return same;
  }

  void check_free_joints() {
    jobs::CompactArray<std::uint8_t> taken = world_.joints.alive;
    for (const std::uint32_t joint : world_.joints.free) {
      archive_.check(joint < taken.size() && !taken[joint], "a list of free joints that has a wrong one");
      taken[joint] = 1;
    }
    archive_.check(std::find(taken.begin(), taken.end(), 0) == taken.end(), "a list of free joints that lacks one");
  }

  // Pairs that users disabled, beside those that joints keep apart.
  void visit_kept_apart() {
    auto& disabled = world_.records.disabled_pairs;
    std::vector<collision::Pair> pairs;  // of those that are read
    std::uint32_t count = 0;
    if constexpr (reads) {
      pairs.resize(archive_.count_of(sizeof(collision::Pair)));
      for (collision::Pair& pair : pairs) {
        visit_pair(archive_, pair);
        check_body(pair.first);
        check_body(pair.second);
        archive_.check(pair.first < pair.second, "a body kept apart from itself");
      }
      restore_disabled_pairs(world_, pairs, apart_before_);
    } else {
      const auto visit_all = [&](const auto& visit) {
        for (const auto& [body, others] : disabled) {
          for (const std::uint32_t other : others) {
            if (body < other) visit(collision::Pair{body, other});
          }
        }
      };
      visit_all([&](const collision::Pair&) { ++count; });
      archive_.value(count);
      visit_all([this](const collision::Pair& pair) { visit_pair(archive_, pair); });
    }
  }

  // Filters of bodies; those of compounds' children are constant.
  void visit_filters() {
    auto& records = world_.records;
    if constexpr (reads) {
      for (std::uint32_t body = 0; body < body_count(); ++body) records.filter.set(body, CollisionFilter{});
    }
    const auto is_filtered = [&](std::uint32_t body) {
      return is_body(body) && records.filter[body] != CollisionFilter{};
    };
    visit_some(archive_, body_count(), is_filtered, [&](std::uint32_t body) {
      check_body(body);
      CollisionFilter filter;
      if constexpr (!reads) filter = records.filter[body];
      visit_filter(archive_, filter);
      if constexpr (reads) records.filter.set(body, filter);
    });
  }

  void visit_boxes() {
    auto& broadphase = world_.broadphase;
    const std::size_t count = world_.colliders.size();
    const auto is_there = [this](std::uint32_t collider) { return is_in_broadphase(world_, collider); };
    visit_filters();
    for (std::uint32_t collider = 0; collider < count; ++collider) {
      if (!is_there(collider)) continue;
      if (world_.colliders.shape[collider].kind == collision::ShapeKind::HalfSpace) {
        collision::Plane plane;
        if constexpr (!reads) plane = broadphase.proxies().plane(collider);
        visit_all(archive_, plane.normal, plane.offset);
        if constexpr (reads) restore_plane(world_, collider, plane);
      } else {
        collision::Aabb box;
        if constexpr (!reads) box = broadphase.proxies().fat_box(collider);
        visit_all(archive_, box.lower, box.upper);
        if constexpr (reads) restore_box(world_, collider, box);
      }
    }
    if constexpr (reads) broadphase.forget_moves();
    const auto has_moved = [&](std::uint32_t collider) { return is_there(collider) && broadphase.has_moved(collider); };
    visit_some(archive_, count, has_moved, [&](std::uint32_t collider) {
      archive_.check(is_there(collider), "the number of a shape that there is not");
      if constexpr (reads) broadphase.mark_moved(collider);
    });
  }

  // Pairs first, so that a reader sees whether it has the same.
  void visit_contacts() {
    auto& cache = world_.cache;
    if constexpr (reads) {
      std::vector<collision::Pair> pairs(archive_.count_of(2));
      collision::Pair before = {};
      for (collision::Pair& pair : pairs) {
        visit_pair_after(before, pair);
        archive_.check(may_touch(world_, pair) && before < pair, "contacts of no valid pairs");
        before = pair;
      }
      restore_pairs(world_, pairs);
    } else {
      archive_.value(static_cast<std::uint32_t>(cache.pairs.size()));
      collision::Pair before = {};
      for (const std::uint32_t slot : cache.all_in_order()) {
        const collision::Contact& contact = cache.contacts[slot];
        if (contact.part != 0) continue;
        visit_pair_after(before, contact.pair);
        before = contact.pair;
      }
    }
    constexpr std::size_t ahead = 8;
    const std::span<const std::uint32_t> slots = cache.all_in_order();
    for (std::size_t i = 0; i < slots.size(); ++i) {
      if (i + ahead < slots.size()) {
        jobs::prefetch(cache.contacts[slots[i + ahead]]);
        jobs::prefetch(cache.manifolds[slots[i + ahead]]);
      }
      visit_one_contact(slots[i]);
    }
  }

  // Pairs come in order, so by what they differ from the one before.
  template <typename Pair>
  void visit_pair_after(const collision::Pair& before, Pair& pair) {
    if constexpr (Archive::hashes) {
      visit_pair(archive_, pair);
    } else {
      std::uint32_t first = 0;
      std::uint32_t second = 0;
      if constexpr (!reads) {
        first = pair.first - before.first;
        second = pair.second - (first == 0 ? before.second : pair.first);
      }
      archive_.small(first);
      archive_.small(second);
      if constexpr (reads) {
        pair.first = before.first + first;
        pair.second = second + (first == 0 ? before.second : pair.first);
      }
    }
  }

  // Every member of the stores is either visited above, or found in the second line of its list: made anew from what
  // was visited, known by the world definition, or of no consequence for the next step. A member that is new has to be
  // put into one. Stores with private members have a list of their own, which is where nobody else can name them.
  void check_members() {
    {
      auto& [gravity, settings, clock, bodies, records, joints, broadphase, aabbs, cache, choices, material_pairs,
             surface_contacts, sleeping, quarantine, selection, control, results, /**/ contents, colliders, active,
             reaches, changes] = world_;
      static_cast<void>(gravity);
    }
    {
      auto& [aabb_margin, aabb_dirty, /**/ margin_limit, sweep_distance] = world_.aabbs.bounds;
      static_cast<void>(aabb_margin);
    }
    {
      auto& [refused, refiltered, /**/ modified] = world_.choices;
      static_cast<void>(refused);
    }
    {
      auto& [steps, last_dt, last_substep, time, /**/ dt] = world_.clock;
      static_cast<void>(steps);
    }
    {
      auto& [positions, orientations, velocities, angular_velocities, forces, torques, surfaces, turned, /**/ mobility,
             inverse_mass, gyroscopic, inertia, inverse_inertia, principal_axes, moments, locks, ball, round,
             min_moment, gravity_scale, linear_damping, angular_damping, radius, joined] = world_.bodies;
      static_cast<void>(positions);
    }
    {
      auto& [disabled_pairs, user_data, names, filter, /**/ generation, alive, type, dynamic, material, centre,
             continuous, sensor, constants, free, count, version, pool] = world_.records;
      static_cast<void>(disabled_pairs);
    }
    {
      auto& [rest_time, ring, unreported, reported_asleep, /**/ awake, asleep, changed, wakeful] = world_.sleeping;
      static_cast<void>(rest_time);
    }
    {
      auto& [touched, reported, /**/ events, before, now] = world_.results.contact_events;
      static_cast<void>(touched);
    }
    {
      auto& [within, /**/ events, before, start_positions, start_orientations] = world_.results.sensor_events;
      static_cast<void>(within);
    }
  }

  Archive& archive_;
  AnyWorld& world_;
  std::vector<std::byte> definition_bytes_;    // scratch, of a reader
  std::vector<collision::Pair> apart_before_;  // of a reader: bodies that didn't touch, in order
};

}  // namespace atl
