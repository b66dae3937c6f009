// The page that plays a run: what it shows is what the run came to, in a browser.

#include <atoll/atoll.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "cli/browser.h"
#include "cli/command.h"

namespace atl::test {
namespace {

// Result of a script that was put at the end of a page and ran once the page was ready. `expression` may await.
std::string asked(const std::string& document) {
  std::smatch found;
  return std::regex_search(document, found, std::regex("data-asked=\"([^\"]*)\"")) ? found[1].str() : "";
}

std::string attribute(const std::string& document, const std::string& name) {
  std::smatch found;
  return std::regex_search(document, found, std::regex("data-" + name + "=\"([^\"]*)\"")) ? found[1].str() : "";
}

std::vector<double> numbers(const std::string& text) {
  std::istringstream words(text);
  std::vector<double> all;
  for (double number = 0; words >> number;) all.push_back(number);
  return all;
}

// A page that lets another script ask it.
std::string without_policy(std::string text) {
  const std::size_t begin = text.find("<meta http-equiv=\"Content-Security-Policy\"");
  return text.erase(begin, text.find('>', begin) + 1 - begin);
}

class ViewPage : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    browser_ = find_browser();
    const CommandResult made =
        run_atoll({"run", GetParam(), "--steps", "130", "--record", recording(), "--view", page()});
    ASSERT_EQ(made.status, 0) << made.err;
    if (!browser_) GTEST_SKIP() << without_browser;
  }

  std::string page() const { return scratch_.path("page.html"); }
  std::string recording() const { return scratch_.path("run.rec"); }

  LoadedPage ask(const std::string& expression, const std::string& place = "") const {
    std::string text = without_policy(read_text(page()));
    const std::size_t end = text.rfind("</body>");
    text.insert(end, R"(<script>(async () => {
      while (document.body.dataset.ready !== 'yes') await new Promise((done) => setTimeout(done, 20));
      document.body.dataset.asked = await (async () => )" +
                         expression + R"()();
    })();</script>)");
    return load_page(*browser_, scratch_.write("asking.html", text), 1100, place, 30);
  }

  ScratchDirectory scratch_;
  std::optional<std::string> browser_;
};

// Compares every body in some steps, out of order, so that frames come from other chunks.
TEST_P(ViewPage, ShowsWhereBodiesWere) {
  const std::vector<int> steps = {130, 0, 61, 59, 60, 7};
  std::string list;
  for (const int step : steps) list += std::to_string(step) + ",";
  const LoadedPage loaded = ask(R"({
    const { film, player } = atoll, all = [];
    for (const step of [)" + list +
                                R"(]) {
      await player.seek(film.frameOf(step));
      all.push(document.body.dataset.step, film.data.precision);
      const frame = film.frame(film.frameOf(step));
      for (let body = 0; body < film.bodies.length; ++body) {
        const pose = film.pose(frame, body);
        all.push(film.bodies[body].id[0], ...pose.position, ...pose.orientation);
      }
    }
    return all.join(' ');
  })");
  EXPECT_EQ(loaded.console, "");
  const std::vector<double> seen = numbers(asked(loaded.document));
  Playback playback(recording());
  playback.seek(0);
  std::size_t at = 0;
  const auto next = [&] { return at < seen.size() ? seen[at++] : NAN; };
  for (const int step : steps) {
    ASSERT_EQ(next(), step);
    const double precision = next();
    EXPECT_LT(precision, 0.01);
    playback.seek(step);
    for (const BodyId id : playback.world().bodies()) {
      ASSERT_EQ(next(), id.index);
      const Pose pose = playback.world().pose(id);
      Pose shown;
      for (int i = 0; i < 3; ++i) shown.position[i] = next();
      for (int i = 0; i < 4; ++i) shown.orientation.coeffs()[i] = next();
      ASSERT_LE((shown.position - pose.position).cwiseAbs().maxCoeff(), 0.51 * precision) << id.index << " in " << step;
      ASSERT_LE(shown.orientation.angularDistance(pose.orientation), 2e-3) << id.index << " in " << step;
    }
  }
  EXPECT_EQ(at, seen.size());
}

// Loads the page as it is, and then with a foreign script, which must not run.
TEST_P(ViewPage, RunsItsOwnScriptAlone) {
  const LoadedPage whole = load_page(*browser_, page(), 1100, "", 30);
  EXPECT_EQ(whole.console, "");
  EXPECT_NE(whole.document.find("data-ready=\"yes\""), std::string::npos);
  std::string text = read_text(page());
  text.insert(text.rfind("</body>"), "<script>document.body.dataset.foreign = 'ran'</script>");
  const LoadedPage harmed = load_page(*browser_, scratch_.write("harmed.html", text), 1100, "", 30);
  EXPECT_EQ(harmed.document.find("data-foreign"), std::string::npos);
  EXPECT_NE(harmed.console.find("Content Security Policy"), std::string::npos) << harmed.console;
}

// The canvas has many colours, where the bodies are drawn, and other ones once they have moved.
TEST_P(ViewPage, DrawsThem) {
  const LoadedPage loaded = ask(R"({
    const look = () => {
      const gl = document.getElementById('stage').getContext('webgl2');
      const pixels = new Uint8Array(4 * gl.drawingBufferWidth * gl.drawingBufferHeight);
      gl.readPixels(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
      return new Uint32Array(pixels.buffer);
    };
    const first = look(), colours = new Set(first);
    await atoll.player.seek(100);
    const changed = look().filter((pixel, i) => pixel !== first[i]).length;
    return [first.length, colours.size, changed].join(' ');
  })",
                                "step=10");
  EXPECT_EQ(loaded.console, "");
  const std::vector<double> seen = numbers(asked(loaded.document));
  ASSERT_EQ(seen.size(), 3u);
  EXPECT_GT(seen[0], 1e5);
  EXPECT_GT(seen[1], 30);
  EXPECT_GT(seen[2], 100);
}

TEST_P(ViewPage, BeginsWhereItsAddressSays) {
  const LoadedPage loaded = load_page(*browser_, page(), 1100, "step=77&body=1&colour=force&contacts&joints&boxes", 30);
  EXPECT_EQ(loaded.console, "");
  EXPECT_EQ(attribute(loaded.document, "ready"), "yes");
  EXPECT_EQ(attribute(loaded.document, "step"), "77");
  Playback playback(recording());
  playback.seek(77);
  const std::vector<double> shown = numbers(attribute(loaded.document, "position"));
  ASSERT_EQ(shown.size(), 3u);
  const Vector3 position = playback.world().pose(playback.world().bodies()[1]).position;
  EXPECT_LT((Vector3(shown[0], shown[1], shown[2]) - position).norm(), 0.01);
  EXPECT_NE(loaded.document.find("aria-label=\"Picked body\""), std::string::npos);
}

TEST_P(ViewPage, Plays) {
  const LoadedPage loaded = ask(R"({
    atoll.player.play();
    // Frames are counted, as without a graphics card one may take long.
    for (let i = 0; i < 200 && !(document.body.dataset.step >= 1); ++i) await new Promise(requestAnimationFrame);
    atoll.player.pause();
    return document.body.dataset.step;
  })");
  EXPECT_EQ(loaded.console, "");
  EXPECT_GE(std::atoi(asked(loaded.document).c_str()), 1);
}

// No window is made as narrow as a phone, so the page is in another one there.
TEST_P(ViewPage, FitsAPhonesScreen) {
  std::string escaped;
  for (const char c : read_text(page())) escaped += c == '&' ? "&amp;" : c == '"' ? "&quot;" : std::string(1, c);
  const std::string outer =
      scratch_.write("phone.html", "<!DOCTYPE html><body><iframe width=\"390\" height=\"800\" srcdoc=\"" + escaped +
                                       R"("></iframe><script>(async () => {
    const page = () => document.querySelector('iframe').contentDocument;
    while (page()?.body?.dataset.ready !== 'yes') await new Promise((done) => setTimeout(done, 50));
    const screen = page().documentElement.clientWidth;
    const beyond = [...page().body.querySelectorAll('*')].filter((each) => each.getBoundingClientRect().right > screen + 0.5);
    const height = page().getElementById('stage').getBoundingClientRect().height;
    document.body.dataset.asked = [screen, page().documentElement.scrollWidth, beyond.length, height].join(' ');
    document.querySelector('iframe').remove();
  })();</script></body>)");
  const LoadedPage loaded = load_page(*browser_, outer, 900, "", 30);
  EXPECT_EQ(loaded.console, "");
  const std::vector<double> seen = numbers(asked(loaded.document));
  ASSERT_EQ(seen.size(), 4u);
  EXPECT_LE(seen[0], 390);
  EXPECT_LE(seen[1], seen[0]);
  EXPECT_EQ(seen[2], 0);
  EXPECT_GT(seen[3], 200);
}

INSTANTIATE_TEST_SUITE_P(Scenes, ViewPage,
                         testing::Values("pile:bodies=60", "ragdolls:count=3", "terrain:bodies=5,triangles=2000",
                                         "vehicle"),
                         [](const auto& of) {
                           return std::string(of.param).substr(0, std::string(of.param).find(':'));
                         });

TEST(View, OfARecordingIsThatOfTheRun) {
  const ScratchDirectory scratch;
  const std::string recording = scratch.path("run.rec"), page = scratch.path("run.html");
  ASSERT_EQ(run_atoll({"run", "pile:bodies=20", "--steps", "40", "--record", recording}).status, 0);
  const CommandResult made = run_atoll({"view", recording, "-o", page, "--from", "10", "--to", "30", "--every", "5"});
  EXPECT_EQ(made.status, 0) << made.err;
  EXPECT_EQ(made.out, page + ": 5 frames, 25 bodies\n");
  EXPECT_NE(read_text(page).find("\"step\":[10,15,20,25,30]"), std::string::npos);
}

TEST(View, ChangesNoBitAndSaysWhatItCannotDo) {
  const ScratchDirectory scratch;
  const CommandResult plain = run_atoll({"run", "ragdolls:count=2", "--steps", "60", "--hash"});
  const CommandResult filmed =
      run_atoll({"run", "ragdolls:count=2", "--steps", "60", "--hash", "--view", scratch.path("run.html")});
  const auto hash_of = [](const CommandResult& result) { return result.out.substr(result.out.rfind("0x")); };
  EXPECT_EQ(hash_of(plain), hash_of(filmed));

  EXPECT_EQ(run_atoll({"view", "pile:bodies=3", "-o", "/nowhere/page.html"}).status, 2);
  EXPECT_EQ(run_atoll({"view", "pile:bodies=3", "--from", "3", "-o", scratch.path("p.html")}).status, 2);
  EXPECT_EQ(run_atoll({"view", "nothing", "-o", scratch.path("p.html")}).status, 3);
  EXPECT_EQ(run_atoll({"view", "pile:bodies=3"}).status, 2);
}

// The world at a step is a scene that goes on from there.
TEST(View, AStepOfARecordingBecomesAScene) {
  const ScratchDirectory scratch;
  const std::string recording = scratch.path("run.rec"), scene = scratch.path("at.json");
  ASSERT_EQ(run_atoll({"run", "pile:bodies=20", "--steps", "40", "--record", recording}).status, 0);
  const CommandResult result = run_atoll({"replay", recording, "--to", "15", "--scene", scene});
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_NE(result.out.find("15 steps"), std::string::npos) << result.out;
  const Scene read = load_scene(scene);
  Playback playback(recording);
  playback.seek(15);
  const std::vector<BodyId> ids = playback.world().bodies();
  ASSERT_EQ(read.bodies.size(), ids.size());
  for (std::size_t i = 0; i < ids.size(); ++i) {
    EXPECT_EQ(read.bodies[i].def.position, playback.world().pose(ids[i]).position);
    EXPECT_EQ(read.bodies[i].def.velocity, playback.world().velocity(ids[i]));
  }
}

// The picture after a step is the same for a scene and for its recording, on any machine.
TEST(Still, IsOfTheStepThatIsAskedFor) {
  const ScratchDirectory scratch;
  const std::string recording = scratch.path("run.rec");
  ASSERT_EQ(run_atoll({"run", "pile:bodies=40", "--steps", "80", "--record", recording}).status, 0);
  const auto picture = [&](const std::string& of, const std::string& name, const std::string& step,
                           const std::string& simd = "auto") {
    const std::string path = scratch.path(name);
    const CommandResult made = run_atoll({"view", of, "--image", path, "--step", step, "--simd", simd});
    EXPECT_EQ(made.status, 0) << made.err;
    EXPECT_EQ(made.out, path + ": after step " + step + "\n");
    return read_text(path);
  };
  const std::string png = picture("pile:bodies=40", "a.png", "70");
  EXPECT_EQ(png.substr(1, 3), "PNG");
  EXPECT_GT(png.size(), 10'000u);
  EXPECT_EQ(picture(recording, "b.png", "70"), png);
  EXPECT_EQ(picture(recording, "c.png", "70", "portable"), png);
  EXPECT_NE(picture(recording, "d.png", "20"), png);

  const std::string svg = picture(recording, "a.svg", "70");
  EXPECT_EQ(svg.substr(0, 4), "<svg");
  std::size_t faces = 0;
  for (std::size_t at = svg.find("<path"); at != std::string::npos; at = svg.find("<path", at + 1)) ++faces;
  // Faces of 40 boxes and the container's front sides; at most three sides of a box show, of two triangles each.
  EXPECT_GT(faces, 40u);
  EXPECT_LE(faces, 40u * 6 + 10);

  EXPECT_EQ(run_atoll({"view", recording, "--image", scratch.path("a.gif")}).status, 2);
  EXPECT_EQ(run_atoll({"view", recording, "--image", scratch.path("a.png"), "--step", "81"}).status, 2);
  EXPECT_EQ(run_atoll({"view", recording}).status, 2);
}

}  // namespace
}  // namespace atl::test
