
#include <atoll/error.h>
#include <jobs/assert.h>
#include <solver/constraints/tendon.h>

#include <cmath>
#include <span>
#include <string>

#include "world/joints.h"
#include "world/make_joint.h"

namespace atl {
namespace {

void check_term(const Stores& world, const TendonTerm& term, const std::string& field) {
  if (!contains(world, term.joint)) {
    throw Error(field + ".joint is (index " + std::to_string(term.joint.index) + ", generation " +
                std::to_string(term.joint.generation) +
                "), which no joint has; expected the id of a joint that has not been removed");
  }
  const JointKind& kind = world.joints.def[term.joint.index]->kind;
  if (std::holds_alternative<TendonJoint>(kind)) throw Error(field + ".joint is a tendon; expected another joint");
  const std::span<const solver::Coordinate> names = named_coordinates(kind);
  if (term.coordinate >= names.size() || is_rate(names[term.coordinate])) {
    throw Error(field + ".coordinate is " + std::to_string(term.coordinate) + "; expected one that a " + name_of(kind) +
                " has, and that isn't a rate only");
  }
}

void check_terms(const Stores& world, const TendonJoint& tendon) {
  for (std::size_t i = 0; i < tendon.terms.size(); ++i) {
    check_term(world, tendon.terms[i], "TendonJoint.terms[" + std::to_string(i) + "]");
  }
}

bool is_same(const solver::TendonTerm& a, const solver::TendonTerm& b) {
  return a.joint == b.joint && a.coordinate == b.coordinate;
}

}  // namespace

JointDef with_bodies(const Stores& world, JointDef def) {
  const auto* tendon = std::get_if<TendonJoint>(&def.kind);
  if (tendon == nullptr) return def;
  check("JointDef.kind", def.kind);
  check_terms(world, *tendon);
  const JointDef& of = *world.joints.def[tendon->terms[0].joint.index];
  def.first = of.first;
  def.second = of.second;
  def.collide = true;
  return def;
}

void bind_tendon(const Stores& world, const JointKind& kind, const solver::Joint& before, solver::Joint& joint) {
  const auto* tendon = std::get_if<TendonJoint>(&kind);
  if (tendon == nullptr) return;
  check_terms(world, *tendon);
  for (std::size_t i = 0; i < joint.terms; ++i) {
    ATL_ASSERT(joint.terms == tendon->terms.size(), joint.terms, tendon->terms.size());
    const TendonTerm& from = tendon->terms[i];
    solver::TendonTerm& term = joint.term[i];
    term.coordinate = named_coordinates(world.joints.def[from.joint.index]->kind)[from.coordinate];
    if (i < before.terms && is_same(term, before.term[i])) term.position = before.term[i].position;
  }
}

void find_length(const Stores& world, solver::Joint& tendon) {
  for (std::size_t i = 0; i < tendon.terms; ++i) {
    solver::TendonTerm& term = tendon.term[i];
    const solver::Joint& of = world.joints.joints[term.joint];
    ATL_ASSERT(term.joint < world.joints.size() && world.joints.alive[term.joint], i, term.joint);
    const std::size_t row = of.row_along(term.coordinate);
    term.position = row < of.rows ? of.position[row] : 0;
  }
  follow_length(world, tendon);
}

void follow_length(const Stores& world, solver::Joint& tendon) {
  const solver::TendonNow now = tendon_now(tendon, world.joints.joints.data(), world.bodies);
  // Bodies so far apart are in quarantine, or will be in the next step.
  for (std::size_t i = 0; i < tendon.terms; ++i) {
    tendon.term[i].position = std::isfinite(now.position[i]) ? now.position[i] : 0;
  }
  tendon.position[0] = std::isfinite(now.length) ? now.length : 0;
}

}  // namespace atl
