// Exports of a run to other programs: poses and forces are those of the run, and files follow their formats.

#include <atoll/atoll.h>
#include <gtest/gtest.h>
#include <hdf5.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "cli/command.h"
#include "support/bodies.h"

namespace atl::test {
namespace {

using Json = nlohmann::ordered_json;

std::string decoded_base64(const std::string& text) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned bits = 0;
  int count = 0;
  for (const char c : text) {
    const std::size_t digit = digits.find(c);
    if (digit == std::string::npos) break;
    bits = bits << 6 | static_cast<unsigned>(digit);
    if ((count += 6) < 8) continue;
    count -= 8;
    bytes.push_back(static_cast<char>(bits >> count & 255));
  }
  return bytes;
}

/// A glTF file as its readers see it.
class Gltf {
 public:
  explicit Gltf(const std::string& text) : json(Json::parse(text)) {
    const std::string uri = json["buffers"][0]["uri"];
    data_ = decoded_base64(uri.substr(uri.find(',') + 1));
    EXPECT_EQ(data_.size(), json["buffers"][0]["byteLength"]);
  }

  std::vector<float> numbers(std::size_t accessor) const {
    const Json& of = json["accessors"][accessor];
    const Json& view = json["bufferViews"][of["bufferView"].get<std::size_t>()];
    const std::map<std::string, std::size_t> widths = {{"SCALAR", 1}, {"VEC3", 3}, {"VEC4", 4}};
    std::vector<float> values(of["count"].get<std::size_t>() * widths.at(of["type"]));
    const std::size_t at = view.value("byteOffset", std::size_t{0});
    EXPECT_LE(at + values.size() * sizeof(float), data_.size());
    std::memcpy(values.data(), data_.data() + at, values.size() * sizeof(float));
    return values;
  }

  /// The channels of a node, by path: a row of numbers for each frame.
  std::map<std::string, std::vector<float>> channels(std::size_t node) const {
    std::map<std::string, std::vector<float>> found;
    const Json& animation = json["animations"][0];
    for (const Json& channel : animation["channels"]) {
      if (channel["target"]["node"] != node) continue;
      const Json& sampler = animation["samplers"][channel["sampler"].get<std::size_t>()];
      found[channel["target"]["path"]] = numbers(sampler["output"]);
    }
    return found;
  }

  Json json;

 private:
  std::string data_;
};

/// A run in which a body comes and another one goes, of shapes of all kinds; some have no names.
void record_run(const std::string& path) {
  World world;
  world.record(path);
  world.add_body(ground());
  world.add_body(
      {.type = BodyType::Kinematic, .shape = Box{{1, 1, 0.1}}, .position = {6, 0, 1}, .velocity = {0, 0.5, 0}});
  world.add_body(
      {.shape = Box{{0.3, 0.2, 0.1}}, .position = {0, 0, 0.8}, .angular_velocity = {3, 1, 2}, .name = "brick"});
  const BodyId goes = world.add_body(sphere({2, 0, 0.5}));
  world.add_body({.shape = Capsule{0.2, 0.4}, .position = {4, 0, 1}});
  world.add_body({.shape = Cylinder{0.2, 0.4}, .position = {4, 2, 1}});
  world.add_body({.shape = Cone{0.2, 0.4}, .position = {4, 4, 1}});
  world.add_body({.shape = Ellipsoid{{0.2, 0.3, 0.4}}, .position = {4, 6, 1}});
  world.add_body({.shape = TaperedCapsule{{0.3, 0.2}, 0.4}, .position = {4, 8, 1}});
  world.add_body({.shape = Compound{{{.shape = Sphere{0.3}, .position = {-0.4, 0, 0}},
                                     {.shape = Box{{0.3, 0.1, 0.1}}, .position = {0.4, 0, 0}}}},
                  .position = {-3, 0, 1}});
  world.add_body(
      {.type = BodyType::Static, .shape = HeightField(2, 3, 1, 1, {0, 0.5, 0, 0, 0.5, 0}), .position = {-8, 0, 0}});
  for (int step = 0; step < 30; ++step) world.step(dt);
  world.remove_body(goes);
  world.add_body(box({2, 0, 0.7}, {0.2, 0.2, 0.2}));
  for (int step = 0; step < 30; ++step) world.step(dt);
  world.stop_recording();
}

class Export : public testing::Test {
 protected:
  void SetUp() override { record_run(recording()); }
  std::string recording() const { return scratch_.path("run.rec"); }
  CommandResult view(std::vector<std::string> more) const {
    more.insert(more.begin(), {"view", recording()});
    return run_atoll(more);
  }

  ScratchDirectory scratch_;
};

TEST_F(Export, PosesInGltfAreThoseOfTheRun) {
  const std::string path = scratch_.path("run.gltf");
  const CommandResult made = view({"--gltf", path, "--every", "5"});
  ASSERT_EQ(made.status, 0) << made.err;
  EXPECT_EQ(made.out, path + ": 13 frames\n");
  const Gltf gltf(read_text(path));
  const std::vector<float> times = gltf.numbers(0);
  ASSERT_EQ(times.size(), 13u);
  Playback playback(recording());
  std::size_t moving = 0, scaled = 0;
  for (std::size_t frame = 0; frame < times.size(); ++frame) {
    playback.seek(5 * static_cast<std::int64_t>(frame));
    EXPECT_NEAR(times[frame], static_cast<double>(5 * frame) * dt, 1e-5);
    const World& world = playback.world();
    std::map<std::string, std::vector<Pose>> expected;  // the body that goes and the one that comes share a name
    for (const BodyId id : world.bodies()) {
      const std::string name(world.name(id));
      expected[name.empty() ? "body " + std::to_string(id.index) : name].push_back(world.pose(id));
    }
    for (std::size_t node = 1; node < gltf.json["nodes"].size(); ++node) {
      const Json& body = gltf.json["nodes"][node];
      const auto channels = gltf.channels(node);
      const auto row = [&](const char* path_of, std::size_t width) {
        std::vector<float> values = body[path_of];
        const auto channel = channels.find(path_of);
        if (channel == channels.end()) return values;
        EXPECT_EQ(channel->second.size(), times.size() * width);
        std::copy_n(channel->second.begin() + static_cast<std::ptrdiff_t>(frame * width), width, values.begin());
        return values;
      };
      moving += channels.contains("translation");
      const auto scale = channels.find("scale");
      scaled += scale != channels.end();
      if (scale != channels.end() && scale->second[3 * frame] == 0) continue;
      const std::vector<float> at = row("translation", 3), turn = row("rotation", 4);
      const std::vector<Pose>& poses = expected[body["name"]];
      ASSERT_EQ(poses.size(), 1u) << body["name"];
      EXPECT_LT((poses[0].position - Vector3(at[0], at[1], at[2])).norm(), 1e-5) << body["name"] << " in " << frame;
      const Quaternion turned(turn[3], turn[0], turn[1], turn[2]);
      EXPECT_LT(turned.angularDistance(poses[0].orientation), 1e-3) << body["name"] << " in " << frame;
      expected.erase(body["name"]);
    }
    EXPECT_TRUE(expected.empty()) << expected.begin()->first;
  }
  EXPECT_EQ(scaled / times.size(), 2u);
  EXPECT_GE(moving / times.size(), 6u);
}

TEST_F(Export, GltfIsValid) {
  const std::string validator = ATOLL_GLTF_VALIDATOR;
  if (validator.empty()) GTEST_SKIP() << "no npm was found: no glTF file is validated";
  const std::string binary = scratch_.path("run.glb"), text = scratch_.path("run.gltf"), one = scratch_.path("one.glb");
  ASSERT_EQ(view({"--gltf", binary}).status, 0);
  ASSERT_EQ(view({"--gltf", text, "--every", "7"}).status, 0);
  ASSERT_EQ(view({"--gltf", one, "--from", "60"}).status, 0);
  for (const std::string& path : {binary, text, one}) {
    const CommandResult found = run_program({ATOLL_NODE, validator, path});
    EXPECT_EQ(found.status, 0) << found.err;
    EXPECT_EQ(found.out, "") << path;
  }
  // The check can fail.
  std::string broken = read_text(text);
  broken.replace(broken.find("\"LINEAR\""), 8, "\"CURVED\"");
  EXPECT_NE(run_program({ATOLL_NODE, validator, scratch_.write("broken.gltf", broken)}).out.find("CURVED"),
            std::string::npos);
}

/// A VTKHDF file as its readers see it.
class Vtk {
 public:
  explicit Vtk(const std::string& path) : file_(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT)) {}
  ~Vtk() { H5Fclose(file_); }
  Vtk(const Vtk&) = delete;
  Vtk& operator=(const Vtk&) = delete;

  bool has(const std::string& name) const { return H5Lexists(file_, ("VTKHDF/" + name).c_str(), H5P_DEFAULT) > 0; }
  std::vector<double> numbers(const std::string& name) const {
    const hid_t set = H5Dopen2(file_, ("VTKHDF/" + name).c_str(), H5P_DEFAULT);
    const hid_t space = H5Dget_space(set);
    std::vector<double> values(static_cast<std::size_t>(std::max<hssize_t>(0, H5Sget_simple_extent_npoints(space))));
    EXPECT_GE(H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), 0) << name;
    H5Sclose(space);
    H5Dclose(set);
    return values;
  }
  std::string type() const {
    const hid_t group = H5Gopen2(file_, "VTKHDF", H5P_DEFAULT);
    const hid_t attribute = H5Aopen(group, "Type", H5P_DEFAULT);
    const hid_t text = H5Aget_type(attribute);
    std::string value(H5Tget_size(text), '\0');
    H5Aread(attribute, text, value.data());
    H5Tclose(text);
    H5Aclose(attribute);
    H5Gclose(group);
    return value;
  }

 private:
  hid_t file_;
};

TEST_F(Export, VtkHoldsSurfacesAndContactForcesOfTheRun) {
  const CommandResult made = view({"--vtk", scratch_.path("run.vtkhdf"), "--every", "20"});
  ASSERT_EQ(made.status, 0) << made.err;
  EXPECT_EQ(made.out, scratch_.path("run_000000.vtkhdf") + " and on: 4 frames\n");
  Playback playback(recording());
  double contacts = 0;
  int boxes = 0;
  for (const int step : {0, 20, 40, 60}) {
    std::string name = std::to_string(step);
    const Vtk file(scratch_.path("run_" + std::string(6 - name.size(), '0') + name + ".vtkhdf"));
    EXPECT_EQ(file.type(), "UnstructuredGrid");
    EXPECT_EQ(file.numbers("FieldData/step"), std::vector<double>{static_cast<double>(step)});
    EXPECT_NEAR(file.numbers("FieldData/time")[0], step * dt, 1e-12);
    const std::vector<double> points = file.numbers("Points"), corners = file.numbers("Connectivity"),
                              offsets = file.numbers("Offsets"), types = file.numbers("Types"),
                              body = file.numbers("CellData/body"), kind = file.numbers("CellData/kind"),
                              force = file.numbers("PointData/contact_force"),
                              velocity = file.numbers("PointData/velocity"),
                              load = file.numbers("CellData/normal_force");
    ASSERT_EQ(file.numbers("NumberOfPoints")[0], points.size() / 3.0);
    ASSERT_EQ(file.numbers("NumberOfCells")[0], types.size());
    ASSERT_EQ(file.numbers("NumberOfConnectivityIds")[0], corners.size());
    ASSERT_EQ(offsets.size(), types.size() + 1);
    ASSERT_TRUE(body.size() == types.size() && kind.size() == types.size() && force.size() == points.size() &&
                velocity.size() == points.size());
    EXPECT_TRUE(std::is_sorted(offsets.begin(), offsets.end()) && offsets.back() == corners.size());
    ASSERT_LT(*std::max_element(corners.begin(), corners.end()), points.size() / 3.0);
    // Compares the data that a reader gets with those of the run.
    while (playback.step() < step) playback.advance();
    const World& world = playback.world();
    std::map<double, Vector3> low, high, fastest;
    Vector3 sum = Vector3::Zero();
    std::size_t points_of_contact = 0;
    for (std::size_t cell = 0; cell < types.size(); ++cell) {
      const auto first = static_cast<std::size_t>(offsets[cell]), end = static_cast<std::size_t>(offsets[cell + 1]);
      ASSERT_EQ(end - first, types[cell] == 5 ? 3u : 1u);
      for (std::size_t i = first; i < end; ++i) {
        const auto at = 3 * static_cast<std::size_t>(corners[i]);
        const Vector3 place(points[at], points[at + 1], points[at + 2]);
        const Vector3 pushes(force[at], force[at + 1], force[at + 2]);
        if (kind[cell] == 3) {
          ++points_of_contact;
          sum += pushes;
          continue;
        }
        EXPECT_EQ(pushes.norm(), 0);
        low.try_emplace(body[cell], place);
        high.try_emplace(body[cell], place);
        low[body[cell]] = low[body[cell]].cwiseMin(place);
        high[body[cell]] = high[body[cell]].cwiseMax(place);
        fastest[body[cell]] = Vector3(velocity[at], velocity[at + 1], velocity[at + 2]);
      }
    }
    Vector3 expected = Vector3::Zero();
    for (const ContactForce& contact : world.contact_forces()) {
      expected += contact.normal_force * contact.normal + contact.friction;
    }
    EXPECT_EQ(points_of_contact, world.contact_forces().size());
    EXPECT_LT((sum - expected).norm(), 1e-5 * (1 + expected.norm()));
    contacts += static_cast<double>(points_of_contact);
    EXPECT_EQ(low.size(), world.body_count());
    for (const BodyId id : world.bodies()) {
      const Pose pose = world.pose(id);
      if (const BodyDef def = world.definition(id); const auto* box = std::get_if<Box>(&def.shape)) {
        const Vector3 reach = pose.orientation.toRotationMatrix().cwiseAbs() * box->half_extents;
        EXPECT_LT((low[id.index] - (pose.position - reach)).norm(), 1e-5) << id.index << " in " << step;
        EXPECT_LT((high[id.index] - (pose.position + reach)).norm(), 1e-5) << id.index << " in " << step;
        ++boxes;
      }
      if (world.type(id) == BodyType::Static) {
        EXPECT_EQ(fastest[id.index].norm(), 0);
      } else if (world.type(id) == BodyType::Kinematic) {
        EXPECT_LT((fastest[id.index] - Vector3(0, 0.5, 0)).norm(), 1e-6);
      } else {
        EXPECT_LT((0.5 * (low[id.index] + high[id.index]) - pose.position).norm(), 0.7) << id.index << " in " << step;
      }
    }
    EXPECT_FALSE(file.has("CellData/contact_residual"));
  }
  EXPECT_GT(contacts, 10);
  EXPECT_EQ(boxes, 10);  // two, and one that comes
}

TEST_F(Export, TwiceTheSameBytes) {
  for (const char* name : {"a", "b"}) {
    const std::string stem = scratch_.path(name);
    ASSERT_EQ(view({"--vtk", stem + ".vtkhdf", "--every", "60", "--gltf", stem + ".glb"}).status, 0);
  }
  EXPECT_EQ(read_text(scratch_.path("a.glb")), read_text(scratch_.path("b.glb")));
  EXPECT_EQ(read_text(scratch_.path("a_000060.vtkhdf")), read_text(scratch_.path("b_000060.vtkhdf")));
}

TEST_F(Export, ASceneTellsItsResiduals) {
  const std::string stem = scratch_.path("stack");
  ASSERT_EQ(run_atoll({"view", "stack:height=3", "--steps", "40", "--every", "40", "--vtk", stem + ".vtkhdf"}).status,
            0);
  const Vtk file(stem + "_000040.vtkhdf");
  const std::vector<double> residual = file.numbers("CellData/contact_residual");
  EXPECT_LT(*std::max_element(residual.begin(), residual.end()), 0.01);
  EXPECT_GT(*std::max_element(residual.begin(), residual.end()), 0);
}

TEST_F(Export, RefusesOtherEndings) {
  expect_refused(view({"--gltf", "run.obj"}), 2, {"--gltf", "\"run.obj\"", ".glb or .gltf"});
  expect_refused(view({"--vtk", "run.vtk"}), 2, {"--vtk", "\"run.vtk\"", ".vtkhdf"});
  expect_refused(view({"--vtk", "/nowhere/run.vtkhdf"}), 2, {"--vtk", "/nowhere"});
}

}  // namespace
}  // namespace atl::test
