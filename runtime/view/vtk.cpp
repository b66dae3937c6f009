#include "view/vtk.h"

#include <atoll/contact_problem.h>
#include <atoll/errors.h>
#include <atoll/world.h>

#include <algorithm>
#include <map>
#include <utility>

#include "view/vtk_file.h"

namespace atl::view {
namespace {

constexpr std::uint8_t vertex_cell = 1, triangle_cell = 5;  // vtkCellType.h
constexpr std::int8_t contact_kind = 3;

// An unstructured grid, column by column.
struct Grid {
  std::vector<float> points, velocity, contact_force;  // three a point
  std::vector<std::int64_t> connectivity, offsets = {0};
  std::vector<std::uint8_t> types, asleep;
  std::vector<std::int32_t> body;
  std::vector<std::int8_t> kind;
  std::vector<float> normal_force, separation, contact_residual;

  void add_point(const Vector3& at, const Vector3& its_velocity, const Vector3& force) {
    for (int i = 0; i < 3; ++i) {
      points.push_back(static_cast<float>(at[i]));
      velocity.push_back(static_cast<float>(its_velocity[i]));
      contact_force.push_back(static_cast<float>(force[i]));
    }
  }

  struct Cell {
    std::int32_t body;
    std::int8_t kind;
    bool asleep;
    double normal_force, separation, residual;
  };
  void add_cell(std::uint8_t type, const Cell& cell) {
    offsets.push_back(static_cast<std::int64_t>(connectivity.size()));
    types.push_back(type);
    body.push_back(cell.body);
    kind.push_back(cell.kind);
    asleep.push_back(cell.asleep);
    normal_force.push_back(static_cast<float>(cell.normal_force));
    separation.push_back(static_cast<float>(cell.separation));
    contact_residual.push_back(static_cast<float>(cell.residual));
  }
  std::int64_t point_count() const { return static_cast<std::int64_t>(points.size() / 3); }
};

// m/s, by BodyId::index: the largest of the contacts of a body.
std::map<std::size_t, double> residuals_of(const ContactProblem& problem) {
  std::map<std::size_t, double> residuals;
  if (problem.patches.empty()) return residuals;
  const ResidualReport report = measure_contact_residual(problem);
  for (std::size_t i = 0; i < problem.patches.size(); ++i) {
    for (const std::size_t side : {problem.patches[i].first, problem.patches[i].second}) {
      if (side == ContactProblem::fixed) continue;
      double& max = residuals[problem.bodies[side].index];
      max = std::max(max, report.by_patch[i]);
    }
  }
  return residuals;
}

void add_bodies(const World& world, Surfaces& surfaces, Grid& grid) {
  std::map<BodyId, double> loads;  // N
  for (const PairForce& pair : world.pair_forces()) {
    loads[pair.a] += pair.normal_force;
    loads[pair.b] += pair.normal_force;
  }
  const std::map<std::size_t, double> residuals = residuals_of(world.contact_problem());
  for (const BodyId id : world.bodies()) {
    if (world.is_quarantined(id)) continue;
    const Triangles& surface = surfaces[surfaces.number_of(world, id)];
    const BodyState state = world.state(id);
    const Pose pose = world.pose(id);
    const Vector3 centre = world.centre_of_mass(id);
    const std::int64_t first = grid.point_count();
    for (const Vector3& vertex : surface.vertices) {
      const Vector3 at = pose.position + pose.orientation * vertex;
      grid.add_point(at, state.velocity + state.angular_velocity.cross(at - centre), Vector3::Zero());
    }
    const auto load = loads.find(id);
    const auto residual = residuals.find(id.index);
    const Grid::Cell cell = {.body = static_cast<std::int32_t>(id.index),
                             .kind = static_cast<std::int8_t>(world.type(id)),
                             .asleep = world.is_asleep(id),
                             .normal_force = load == loads.end() ? 0 : load->second,
                             .separation = 0,
                             .residual = residual == residuals.end() ? 0 : residual->second};
    for (const auto& triangle : surface.triangles) {
      for (const std::uint32_t vertex : triangle) grid.connectivity.push_back(first + vertex);
      grid.add_cell(triangle_cell, cell);
    }
  }
}

void add_contacts(const World& world, Grid& grid) {
  for (const ContactForce& contact : world.contact_forces()) {
    grid.connectivity.push_back(grid.point_count());
    grid.add_point(contact.position, Vector3::Zero(), contact.normal_force * contact.normal + contact.friction);
    grid.add_cell(vertex_cell, {.body = static_cast<std::int32_t>(contact.b.index),
                                .kind = contact_kind,
                                .asleep = false,
                                .normal_force = contact.normal_force,
                                .separation = contact.separation,
                                .residual = 0});
  }
}

}  // namespace

static_assert(static_cast<int>(BodyType::Static) == 0 && static_cast<int>(BodyType::Kinematic) == 1 &&
              static_cast<int>(BodyType::Dynamic) == 2);

bool has_vtk() { return true; }

VtkSeries::VtkSeries(const VtkOptions& options, Sink sink)
    : clock_(options.first_step, options.stride), sink_(std::move(sink)) {}

void VtkSeries::add(const World& world, const StepReport&, double dt) {
  if (clock_.tick(dt)) write_frame(world);
}

void VtkSeries::write_frame(const World& world) {
  Grid grid;
  add_bodies(world, surfaces_, grid);
  add_contacts(world, grid);
  VtkFile file;
  const std::vector<std::int64_t> points = {grid.point_count()};
  const std::vector<std::int64_t> cells = {static_cast<std::int64_t>(grid.types.size())};
  const std::vector<std::int64_t> corners = {static_cast<std::int64_t>(grid.connectivity.size())};
  file.write("NumberOfPoints", points);
  file.write("NumberOfCells", cells);
  file.write("NumberOfConnectivityIds", corners);
  file.write("Points", grid.points, 3);
  file.write("Connectivity", grid.connectivity);
  file.write("Offsets", grid.offsets);
  file.write("Types", grid.types);
  file.write("PointData/velocity", grid.velocity, 3);
  file.write("PointData/contact_force", grid.contact_force, 3);
  file.write("CellData/body", grid.body);
  file.write("CellData/kind", grid.kind);
  file.write("CellData/asleep", grid.asleep);
  file.write("CellData/normal_force", grid.normal_force);
  file.write("CellData/separation", grid.separation);
  if (world.settings().keep_contact_problem) file.write("CellData/contact_residual", grid.contact_residual);
  file.write("FieldData/time", std::vector<double>{clock_.time()});
  file.write("FieldData/step", std::vector<std::int64_t>{clock_.step()});
  sink_(clock_.step(), file.bytes());
  ++frames_;
}

}  // namespace atl::view
