// Files from others: what a scene may read, what stands where a file is expected, and text that goes to a terminal.

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>

#include "cli/command.h"

namespace atl::test {
namespace {

namespace fs = std::filesystem;

std::string mesh_scene(const std::string& file) {
  return R"({"format": "atoll-scene", "version": 1, "steps": 1, "bodies": [
    {"type": "static", "shape": {"type": "mesh", "file": ")" +
         file + R"("}}]})";
}

std::string ball_scene(const std::string& more) {
  return R"({"format": "atoll-scene", "version": 1, "steps": 1, "bodies": [
    {"shape": {"type": "sphere", "radius": 1}}])" +
         more + "}";
}

constexpr const char* triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

std::string pipe_in(const ScratchDirectory& folder, const std::string& name) {
  EXPECT_EQ(::mkfifo(folder.path(name).c_str(), 0600), 0);
  return folder.path(name);
}

TEST(CommandUntrusted, AMeshIsReadBelowTheScenesFolderOnly) {
  const ScratchDirectory folder;
  fs::create_directories(folder.path("scenes/meshes"));
  folder.write("outside.obj", triangle);
  folder.write("scenes/meshes/inside.obj", triangle);
  fs::create_symlink("../outside.obj", folder.path("scenes/link.obj"));
  const std::string inside = folder.write("scenes/inside.json", mesh_scene("meshes/../meshes/inside.obj"));
  EXPECT_EQ(run_atoll({"run", inside}).status, 0);
  for (const std::string& file : {std::string("../outside.obj"), folder.path("outside.obj"), std::string("link.obj")}) {
    SCOPED_TRACE(file);
    const std::string scene = folder.write("scenes/outside.json", mesh_scene(file));
    expect_refused(run_atoll({"run", scene}), 3,
                   {"outside.json:2: /bodies/0/shape/file: ", "below the scene file's folder"});
    EXPECT_EQ(run_atoll({"run", scene, "--allow-outside"}).status, 0);
  }
}

TEST(CommandUntrusted, PipesAndDevicesAreNotRead) {
  const ScratchDirectory folder;
  const std::string pipe = pipe_in(folder, "pipe");
  const std::string scene = folder.write("scene.json", mesh_scene("pipe"));
  expect_refused(run_atoll({"run", scene}), 3,
                 {"/bodies/0/shape/file: ", "found a directory, pipe or device, expected a Wavefront OBJ file"});
  const std::string device = folder.write("device.json", mesh_scene("/dev/zero"));
  expect_refused(run_atoll({"run", device, "--allow-outside"}), 3,
                 {"found a directory, pipe or device, expected a Wavefront OBJ file"});
  expect_refused(run_atoll({"run", pipe}), 3, {"found a directory, pipe or device, expected a scene file"});
  expect_refused(run_atoll({"view", pipe, "--page", folder.path("page.html")}), 3,
                 {"found a directory, pipe or device"});
  expect_refused(run_atoll({"replay", pipe}), 3, {"is a pipe; expected a recording's file"});
  expect_refused(run_atoll({"replay", "/dev/zero"}), 3, {"is a device; expected a recording's file"});
}

TEST(CommandUntrusted, MessagesAreShortAndOfPrintableText) {
  const ScratchDirectory folder;
  const struct {
    std::string name, text, expected;
  } cases[] = {
      {"digits.json", ball_scene(R"(, "dt": )" + std::string(100'000, '9')), "a number that a double can hold"},
      {"key.json", ball_scene(R"(, "a\u001b[2Jb)" + std::string(100'000, 'k') + R"(": 1)"), "found the unknown key"},
      {"name.json", ball_scene(R"(, "name": "a\nb")"), R"("a\x0ab")"},
      {"file\x1b[2J\n.json", "{", R"(file\x1b[2J\x0a.json:1:2: )"},
  };
  for (const auto& bad : cases) {
    SCOPED_TRACE(bad.name);
    const CommandResult result = run_atoll({"run", folder.write(bad.name, bad.text)});
    expect_refused(result, 3, {bad.expected});
    EXPECT_LT(result.err.size(), 4000u);
    EXPECT_EQ(result.err.find('\x1b'), std::string::npos);
  }
  const CommandResult usage = run_atoll({"run", "stack", "--st\x1b[2Jeps"});
  expect_refused(usage, 2, {R"(--st\x1b[2Jeps)"});
}

TEST(CommandUntrusted, NumbersThatNoWorldTakesAreToldWhereTheyStand) {
  const ScratchDirectory folder;
  const std::string scene = folder.write("short.json", ball_scene(",\n\"dt\": 1e-300"));
  expect_refused(run_atoll({"run", scene}), 3, {"short.json:3: /dt: found 1e-300, expected a number in [1e-12, 1]"});
  const std::string large = folder.write("large.json", ball_scene(",\n\"settings\": {\"slop\": 1e38}"));
  expect_refused(run_atoll({"run", large}), 3, {"large.json:3: /settings: Settings.slop is 1e+38; expected"});
  expect_refused(run_atoll({"run", "stack", "--dt", "1e-300"}), 2, {"--dt", "[1e-12, 1]"});
}

// The bytes of the script's hash in a page's policy, and the hash of its last script, each in hexadecimal.
std::string hashes_of(const std::string& page) {
  const CommandResult found = run_program(
      {"/bin/bash", "-c",
       R"(grep -o "sha256-[^']*" "$1" | head -1 | cut -d- -f2- | base64 -d | od -An -v -tx1 | tr -d ' \n'; echo;
          perl -0777 -ne 'print $1 if m{.*<script>(.*?)</script>}s' "$1" | sha256sum | cut -d' ' -f1)",
       "bash", page});
  return found.out + found.err;
}

TEST(CommandUntrusted, PagesAllowTheirOwnScriptAlone) {
  const ScratchDirectory folder;
  ASSERT_EQ(run_atoll({"run", "stack:height=2", "--steps", "2", "--view", folder.path("view.html")}).status, 0);
  ASSERT_EQ(run_atoll({"sweep", "stack:height=2", "--substeps", "1", "--iterations", "1", "--steps", "2", "--repeats",
                       "1", "--time", "1e-6", "--out", folder.path("sweep")})
                .status,
            0);
  for (const std::string name : {"view.html", "sweep/index.html"}) {
    SCOPED_TRACE(name);
    const std::string page = read_text(folder.path(name));
    const std::size_t policy =
        page.find("\"Content-Security-Policy\" content=\"default-src 'none'; script-src 'sha256-");
    ASSERT_NE(policy, std::string::npos);
    EXPECT_LT(policy, page.find("<style"));
    const std::vector<std::string> hashes = lines_of(hashes_of(folder.path(name)));
    ASSERT_EQ(hashes.size(), 2u);
    EXPECT_EQ(hashes[0].size(), 64u);
    EXPECT_EQ(hashes[0], hashes[1]);
  }
}

}  // namespace
}  // namespace atl::test
