#include "memory_need.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>

namespace atl::scene {
namespace {

// Bytes of atoll run on x86-64, from the most that was resident (ru_maxrss) less the 11 MB of a scene of nothing.
// Scenes that need less than what these come to are hardly ever refused, as they are near the least that was measured.
//
// A body with its contacts: boxes of stack:height=10000 5.3 kB, islands:count=10000,base=4 5.4 kB, blocks of
// sliding-blocks:headings=10000 5.6 kB, wall:base=400 7.0 kB, pile:bodies=20000 9.7 kB, pyramid3d:layers=100 10 kB.
// Balls that touch nothing yet (marbles:bodies=100000) 3.8 kB.
constexpr double bytes_of_body = 5e3;
// joint-grid:n=100 13.2 kB for a ball and two joints, less 3.8 kB of the ball; chain:links=10000 5.1 kB likewise.
constexpr double bytes_of_joint = 4.7e3;
// rocks:bodies=5000 25 kB for one of 30 vertices, 15 kB more than a box of the pile; terrain:bodies=2000 13 kB for one
// of the 20 hulls of a body.
constexpr double bytes_of_hull_vertex = 400;
// terrain:bodies=10 with 100,000 and with 2,000,000 triangles.
constexpr double bytes_of_triangle = 270;

// Bytes in a line "Name: 1234 kB".
double meminfo(const std::string& name) {
  std::ifstream file("/proc/meminfo");
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with(name + ":")) return 1024 * std::stod(line.substr(name.size() + 1));
  }
  return std::numeric_limits<double>::infinity();
}

double number_in(const char* path) {
  std::ifstream file(path);
  double number = 0;
  return file >> number ? number : std::numeric_limits<double>::infinity();
}

// Memory that the control group of a container still has, bytes.
double left_of_group() {
  const double max = number_in("/sys/fs/cgroup/memory.max");
  const double used = number_in("/sys/fs/cgroup/memory.current");
  return std::isfinite(max) && std::isfinite(used) ? max - used : std::numeric_limits<double>::infinity();
}

// Address space left below RLIMIT_AS, which ulimit -v sets, bytes.
double left_of_limit() {
  rlimit limit = {};
  if (::getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) {
    return std::numeric_limits<double>::infinity();
  }
  const double pages = number_in("/proc/self/statm");
  const double mapped = std::isfinite(pages) ? pages * static_cast<double>(::sysconf(_SC_PAGESIZE)) : 0;
  return static_cast<double>(limit.rlim_cur) - mapped;
}

double free_pages() {
  const double pages = static_cast<double>(::sysconf(_SC_AVPHYS_PAGES));
  return pages > 0 ? pages * static_cast<double>(::sysconf(_SC_PAGESIZE)) : std::numeric_limits<double>::infinity();
}

std::string bytes_text(double bytes) {
  constexpr std::array units = {"B", "kB", "MB", "GB", "TB", "PB", "EB"};
  std::size_t unit = 0;
  while (bytes >= 999.5 && unit + 1 < units.size()) {
    bytes /= 1000;
    ++unit;
  }
  std::array<char, 32> text = {};
  std::snprintf(text.data(), text.size(), "%.3g %s", std::max(bytes, 0.0), units[unit]);
  return text.data();
}

}  // namespace

double SceneSize::bytes() const {
  return bytes_of_body * bodies + bytes_of_joint * joints + bytes_of_hull_vertex * hull_vertices +
         bytes_of_triangle * triangles;
}

double available_memory() {
  const double system = meminfo("MemAvailable");
  return std::min({std::isfinite(system) ? system : free_pages(), left_of_group(), left_of_limit()});
}

std::string memory_words(double bytes) {
  const double there = available_memory();
  if (!(bytes > there)) return "";
  return "about " + bytes_text(bytes) + " of memory, of which " + bytes_text(there) + " are free";
}

}  // namespace atl::scene
