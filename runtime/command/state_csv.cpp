#include "state_csv.h"

#include <charconv>
#include <ostream>
#include <string>

namespace atl::command {
namespace {

// RFC 4180: quoted where it has to be, quotes doubled.
void append_text(std::string& row, const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) {
    row += text;
    return;
  }
  row += '"';
  for (const char c : text) row.append(c == '"' ? 2 : 1, c);
  row += '"';
}

template <class Column>
void append_numbers(std::string& row, const Column& column) {
  constexpr int digits = 17;  // enough for any double to come back as it was
  char text[32];
  for (const double x : column) {
    row += ',';
    row.append(text, std::to_chars(text, text + sizeof text, x, std::chars_format::general, digits).ptr);
  }
}

}  // namespace

void BodyStates::copy(const World& world) {
  positions_ = world.positions();
  orientations_ = world.orientations();
  velocities_ = world.velocities();
  angular_velocities_ = world.angular_velocities();
}

void BodyStates::write_csv(std::ostream& out, const Scene& scene, const std::vector<BodyId>& ids) const {
  out << "id,name,px,py,pz,qx,qy,qz,qw,vx,vy,vz,wx,wy,wz\n";
  std::string row;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const Eigen::Index column = ids[i].index;
    row = std::to_string(i) + ",";
    append_text(row, scene.bodies[i].name);
    append_numbers(row, positions_.col(column));
    append_numbers(row, orientations_.col(column));
    append_numbers(row, velocities_.col(column));
    append_numbers(row, angular_velocities_.col(column));
    out << row << '\n';
  }
}

}  // namespace atl::command
