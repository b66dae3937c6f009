#include <libqhull_r/qhull_ra.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>

#include "shapes/hull_build.h"

namespace atl::collision {
namespace {

using Corner = std::uint32_t;
using FacetSide = std::array<Corner, 2>;

// Qhull's state and the stream it complains to, freed together. Qhull's own error exits only ever leave
// qh_new_qhull, which catches them; nothing that can raise one is called after it.
class Qhull {
 public:
  Qhull(std::span<const Vector3> points, const std::string& options) : log_(open_memstream(&text_, &length_)) {
    for (const Vector3& point : points) coordinates_.insert(coordinates_.end(), {point.x(), point.y(), point.z()});
    qh_zero(&state_, log_);
    std::string command = "qhull " + options;
    status_ = qh_new_qhull(&state_, 3, static_cast<int>(points.size()), coordinates_.data(), False, command.data(),
                           log_, log_);
  }
  ~Qhull() {
    qh_freeqhull(&state_, !qh_ALL);
    int blocks = 0;
    int bytes = 0;
    qh_memfreeshort(&state_, &blocks, &bytes);
    if (log_ != nullptr) std::fclose(log_);
    std::free(text_);
  }
  Qhull(const Qhull&) = delete;
  Qhull& operator=(const Qhull&) = delete;

  bool failed() const { return status_ != 0; }
  std::string complaint() {
    if (log_ == nullptr || std::fflush(log_) != 0) return "qhull failed";
    const std::string all(text_, length_);
    return all.substr(0, all.find('\n'));
  }
  const facetT* first_facet() const { return state_.facet_list; }
  Corner corner(const void* vertex) const {
    return static_cast<Corner>((static_cast<const vertexT*>(vertex)->point - state_.first_point) / 3);
  }

 private:
  char* text_ = nullptr;
  std::size_t length_ = 0;
  std::FILE* log_;
  std::vector<double> coordinates_;
  qhT state_ = {};
  int status_ = 0;
};

// Elements of one of qhull's sets, which end with a null.
template <typename Visit>
void for_each(const setT* set, const Visit& visit) {
  if (set == nullptr) return;
  for (const setelemT* element = set->e; element->p != nullptr; ++element) visit(element->p);
}

void collect_sides(const Qhull& qhull, const facetT& facet, std::vector<FacetSide>& sides) {
  sides.clear();
  if (facet.simplicial) {
    std::vector<Corner> corners;
    for_each(facet.vertices, [&](const void* vertex) { corners.push_back(qhull.corner(vertex)); });
    for (std::size_t i = 0; i < corners.size(); ++i) sides.push_back({corners[i], corners[(i + 1) % corners.size()]});
    return;
  }
  for_each(facet.ridges, [&](const void* ridge) {
    std::vector<Corner> ends;
    for_each(static_cast<const ridgeT*>(ridge)->vertices,
             [&](const void* vertex) { ends.push_back(qhull.corner(vertex)); });
    if (ends.size() == 2) sides.push_back({ends[0], ends[1]});
  });
}

// Sides, put in an order in which each begins where the last one ended. False where they aren't one loop.
bool chain(std::vector<FacetSide>& sides, std::vector<Corner>& loop) {
  loop.clear();
  if (sides.size() < 3) return false;
  for (std::size_t i = 0; i + 1 < sides.size(); ++i) {
    const Corner end = sides[i][1];
    loop.push_back(sides[i][0]);
    std::size_t next = i + 1;
    while (next < sides.size() && sides[next][0] != end && sides[next][1] != end) ++next;
    if (next == sides.size()) return false;
    std::swap(sides[i + 1], sides[next]);
    if (sides[i + 1][0] != end) std::swap(sides[i + 1][0], sides[i + 1][1]);
  }
  loop.push_back(sides.back()[0]);
  return sides.back()[1] == loop.front();
}

// Twice the area of a polygon, seen along a direction.
double doubled_area(std::span<const Vector3> points, const std::vector<Corner>& loop, const Vector3& direction) {
  Vector3 sum = Vector3::Zero();
  for (std::size_t i = 1; i + 1 < loop.size(); ++i) {
    sum += (points[loop[i]] - points[loop[0]]).cross(points[loop[i + 1]] - points[loop[0]]);
  }
  return sum.dot(direction);
}

}  // namespace

std::string find_facets(std::span<const Vector3> points, double tolerance, ConvexFacets& facets) {
  facets = ConvexFacets{};
  std::array<char, 32> merge;
  std::snprintf(merge.data(), merge.size(), "C-%.17g", tolerance);
  Qhull qhull(points, merge.data());
  if (qhull.failed()) return qhull.complaint();

  std::vector<FacetSide> sides;
  std::vector<Corner> loop;
  // The list ends with an empty facet.
  for (const facetT* facet = qhull.first_facet(); facet != nullptr && facet->next != nullptr; facet = facet->next) {
    collect_sides(qhull, *facet, sides);
    if (!chain(sides, loop)) return "a face whose sides are not one loop";
    const Vector3 normal(facet->normal[0], facet->normal[1], facet->normal[2]);
    if (doubled_area(points, loop, normal) < 0) std::reverse(loop.begin(), loop.end());
    facets.add(loop);
  }
  return {};
}

}  // namespace atl::collision
