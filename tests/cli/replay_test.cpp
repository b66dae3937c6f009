// Files of `atoll run --record`, and output and exit status of `atoll replay`.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "cli/command.h"
#include "support/recording_file.h"

namespace atl::test {
namespace {

using Json = nlohmann::ordered_json;

std::vector<std::string> with(std::vector<std::string> words, const std::vector<std::string>& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

/// A run of two crates, of which the second is pushed and touches nothing, and its recording.
class PushedCrate {
 public:
  PushedCrate() {
    directory_.write("crates.json", R"({"format": "atoll-scene", "version": 1, "steps": 40, "bodies": [
        {"name": "still", "shape": {"type": "box", "half_extents": [1, 1, 1]}},
        {"name": "pushed", "shape": {"type": "box", "half_extents": [1, 1, 1]}, "position": [9, 0, 0],
         "force": [3, 0, 0]}]})");
  }

  std::vector<std::string> run(const std::vector<std::string>& more) const {
    return with({"run", directory_.path("crates.json"), "--threads", "2", "--simd", "portable"}, more);
  }
  std::string record() const {
    EXPECT_EQ(run_atoll(run({"--record", path("run.recording")})).status, 0);
    return path("run.recording");
  }
  std::string path(const std::string& name) const { return directory_.path(name); }
  void write(const std::string& name, const std::string& content) const { directory_.write(name, content); }
  std::vector<std::string> files() const { return directory_.files(); }

 private:
  ScratchDirectory directory_;
};

// The line that a command prints its state hash on.
std::string hash_of(const std::vector<std::string>& words) {
  const CommandResult result = run_atoll(with(words, {"--hash"}));
  EXPECT_EQ(result.status, 0) << result.err;
  return lines_of(result.out).back();
}

TEST(CommandReplay, HelpHasEveryOption) {
  const CommandResult help = run_atoll({"replay", "--help"});
  EXPECT_EQ(help.status, 0);
  for (const char* word : {"FILE", "--threads", "--simd auto|portable", "--format text|json"}) {
    EXPECT_NE(help.out.find(word), std::string::npos) << word;
  }
  EXPECT_NE(run_atoll({"run", "--help"}).out.find("--record FILE"), std::string::npos);
}

TEST(CommandReplay, ComesToTheSameOnAnyMachine) {
  const ScratchDirectory directory;
  const std::string path = directory.path("run.recording");
  for (const char* scene :
       {"ragdolls:count=1", "islands:count=3,base=3", ATOLL_SOURCE_DIR "/runtime/scene/examples/shapes.json"}) {
    const std::vector<std::string> words = {"run", scene, "--steps", "20", "--sleeping", "--substeps", "3"};
    const std::string hash = hash_of(words);
    EXPECT_EQ(hash_of(with(words, {"--record", path})), hash) << "recording changes nothing";
    EXPECT_EQ(directory.files(), std::vector<std::string>{"run.recording"});
    for (const char* threads : {"1", "3"}) {
      for (const char* simd : {"auto", "portable"}) {
        const CommandResult result = run_atoll({"replay", path, "--threads", threads, "--simd", simd});
        EXPECT_EQ(result.status, 0) << result.err;
        EXPECT_EQ(result.err, "");
        const std::vector<std::string> lines = lines_of(result.out);
        ASSERT_EQ(lines.size(), 4u) << result.out;
        EXPECT_EQ(lines[3], "result     same after every step, bit for bit; hash " + hash);
      }
    }
  }
}

TEST(CommandReplay, TellsOfTheRecordingAndTheReplay) {
  const PushedCrate crate;
  const std::string path = crate.record();
  const CommandResult text = run_atoll({"replay", path, "--threads", "1", "--simd", "portable"});
  const std::vector<std::string> lines = lines_of(text.out);
  ASSERT_EQ(lines.size(), 4u) << text.out;
  EXPECT_EQ(lines[0], "recording  " + path);
  EXPECT_EQ(lines[1], "recorded   40 steps; 2 threads, portable");
  EXPECT_EQ(lines[2], "replayed   40 steps; 1 thread, portable");
  const CommandResult result = run_atoll({"replay", path, "--threads", "1", "--format", "json"});
  EXPECT_EQ(result.status, 0) << result.err;
  const Json json = Json::parse(result.out);
  EXPECT_EQ(json["format"], "atoll-replay");
  EXPECT_EQ(json["version"], 1);
  EXPECT_EQ(json["recording"], path);
  EXPECT_EQ(json["recorded"]["threads"], 2);
  EXPECT_EQ(json["recorded"]["simd"], "portable");
  EXPECT_EQ(json["replayed"]["threads"], 1);
  EXPECT_NE(json["replayed"]["simd"], "auto");
  EXPECT_EQ(json["recorded_steps"], 40);
  EXPECT_EQ(json["steps"], 40);
  EXPECT_EQ(json["complete"], true);
  EXPECT_EQ(json["same"], true);
  EXPECT_EQ(json["hash"], hash_of(crate.run({})));
  EXPECT_FALSE(json.contains("divergence"));
}

TEST(CommandReplay, NamesTheStepAndTheBodyOfAChangedForce) {
  const PushedCrate crate;
  const std::string path = crate.record();
  change_a_force(path, 16);
  const CommandResult text = run_atoll({"replay", path});
  EXPECT_EQ(text.status, 1);
  const std::vector<std::string> lines = lines_of(text.out);
  ASSERT_EQ(lines.size(), 5u) << text.out;
  EXPECT_TRUE(lines[2].starts_with("replayed   17 steps; ")) << lines[2];
  EXPECT_EQ(lines[3], "result     differs in step 17: 1 body");
  EXPECT_TRUE(lines[4].starts_with("           body 1: ")) << lines[4];
  EXPECT_NE(lines[4].find("velocity"), std::string::npos) << lines[4];
  ASSERT_EQ(lines_of(text.err).size(), 1u) << text.err;
  EXPECT_NE(text.err.find("differs from what was recorded: step 17, body 1: "), std::string::npos) << text.err;

  const CommandResult result = run_atoll({"replay", path, "--format", "json"});
  EXPECT_EQ(result.status, 1);
  const Json json = Json::parse(result.out);
  EXPECT_EQ(json["same"], false);
  EXPECT_EQ(json["steps"], 17);
  EXPECT_EQ(json["divergence"]["step"], 17);
  EXPECT_EQ(json["divergence"]["bodies_step"], 17);
  ASSERT_EQ(json["divergence"]["bodies"].size(), 1u);
  EXPECT_EQ(json["divergence"]["bodies"][0]["body"], 1);
  EXPECT_EQ(json["divergence"]["bodies"][0]["generation"], 0);
  EXPECT_FALSE(json["divergence"]["bodies"][0]["differs"].empty());
}

TEST(CommandReplay, ReplaysWhatIsCutOff) {
  const PushedCrate crate;
  const std::string path = crate.record();
  const std::string whole = read_text(path);
  crate.write("cut.recording", whole.substr(0, whole.size() / 2));
  const CommandResult result = run_atoll({"replay", crate.path("cut.recording"), "--format", "json"});
  EXPECT_EQ(result.status, 0) << result.err;
  const Json json = Json::parse(result.out);
  EXPECT_EQ(json["complete"], false);
  EXPECT_EQ(json["same"], true);
  EXPECT_GT(json["steps"], 5);
  EXPECT_LT(json["steps"], 40);
  EXPECT_EQ(json["steps"], json["recorded_steps"]);
  const CommandResult text = run_atoll({"replay", crate.path("cut.recording")});
  EXPECT_NE(text.out.find("cut off"), std::string::npos) << text.out;
}

TEST(CommandReplay, RefusesWhatIsNoWholeRecording) {
  const PushedCrate crate;
  const std::string path = crate.path("run.recording");
  expect_refused(run_atoll({"replay", path}), 3, {path, "No such file"});
  crate.write("run.recording", "{}");
  expect_refused(run_atoll({"replay", path}), 3, {path, "ATOLLREC", "expected a recording"});
  crate.record();
  std::string bytes = read_text(path);
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] + 1);
  crate.write("run.recording", bytes);
  expect_refused(run_atoll({"replay", path}), 3, {path, "record ", "expected", "damaged"});
  expect_refused(run_atoll({"replay"}), 2, {"FILE", "replay --help"});
  expect_refused(run_atoll({"replay", path, "--threads", "0"}), 2, {"--threads", "\"0\""});
}

TEST(CommandReplay, ARecordingNeedsAFileOfItsOwn) {
  const PushedCrate crate;
  const std::string path = crate.path("file");
  expect_refused(run_atoll(crate.run({"--record", path, "--out", path})), 2, {"--record", "the file of --out"});
  expect_refused(run_atoll(crate.run({"--record", "/nowhere/at/all"})), 2, {"--record", "/nowhere/at/all"});
  expect_refused(run_atoll(crate.run({"--record", ""})), 2, {"--record", "file name"});
  EXPECT_EQ(crate.files(), std::vector<std::string>{"crates.json"});
}

TEST(Bisect, TellsWhereTwoRunsPartAndShowsIt) {
  const ScratchDirectory scratch;
  const std::string plain = scratch.path("a.rec"), other = scratch.path("b.rec"), page = scratch.path("parting.html");
  ASSERT_EQ(run_atoll({"run", "stack:height=3", "--steps", "90", "--record", plain}).status, 0);
  ASSERT_EQ(run_atoll({"run", "stack:height=3", "--steps", "90", "--iterations", "3", "--record", other}).status, 0);
  const CommandResult same = run_atoll({"bisect", plain, plain});
  EXPECT_EQ(same.status, 0) << same.err;
  EXPECT_NE(same.out.find("same in 90 steps, bit for bit"), std::string::npos) << same.out;

  const CommandResult parted = run_atoll({"bisect", plain, other, "--view", page});
  EXPECT_EQ(parted.status, 1);
  EXPECT_NE(parted.out.find("part       by calls ahead of step 1 (2 replays)"), std::string::npos) << parted.out;
  EXPECT_NE(parted.err.find("parts from " + plain + " by calls ahead of step 1"), std::string::npos) << parted.err;
  EXPECT_NE(parted.out.find("bodies     part in solve_islands of step "), std::string::npos) << parted.out;
  EXPECT_NE(read_text(page).find("\"place\":\"step="), std::string::npos);

  EXPECT_EQ(run_atoll({"bisect", plain, "/nowhere"}).status, 3);
  EXPECT_EQ(run_atoll({"bisect", plain}).status, 2);
}

}  // namespace
}  // namespace atl::test
