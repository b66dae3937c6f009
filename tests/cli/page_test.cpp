// The page that a sweep writes, in a browser.

#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>

#include "cli/browser.h"
#include "cli/command.h"
#include "cli/driver_script.h"
#include "support/long_tests.h"

namespace atl::test {
namespace {

using Json = nlohmann::ordered_json;

// A sweep with runs of every kind: done, without error, fallen, non-finite, stopped.
class SweepPage : public testing::Test {
 protected:
  void SetUp() override { sweep(); }

  void sweep() {
    const CommandResult result =
        run_atoll(words_of("sweep stack:height=2 pile:bodies=3 " + hostile_scene() +
                           " --substeps 1,4 --iterations 1 --simd auto --steps 30 --repeats 2 --time 1e-6 --peer " +
                           write_driver(scratch_, "Mock") + " --peer-limit 1 --views --out " + scratch_.path("out")));
    ASSERT_EQ(result.status, 0) << result.err;
    results_ = Json::parse(read_text(scratch_.path("out") + "/results.json"));
  }

  std::string page() const { return scratch_.path("out") + "/index.html"; }

  std::string hostile_scene() const {
    return scratch_.write("<!--<script>&amp;.json", R"({"format": "atoll-scene", "version": 1,
      "bodies": [{"shape": {"type": "sphere", "radius": 1}}]})");
  }

  ScratchDirectory scratch_;
  Json results_;
};

// The page of such a sweep in a browser, without which it is not swept.
class LoadedSweepPage : public SweepPage {
 protected:
  void SetUp() override {
    browser_ = find_browser();
    if (browser_) return sweep();
    const char* ci = std::getenv("CI");
    if (long_tests() && ci != nullptr && std::string(ci) == "true") FAIL() << "no Chromium was found where CI=true";
    GTEST_SKIP() << without_browser;
  }

  std::optional<std::string> browser_;
};

std::size_t count(const std::string& text, const std::string& word) {
  std::size_t found = 0;
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++found;
  return found;
}

// Runs that have a place in a scene's first diagram.
std::set<std::size_t> drawn_runs(const Json& scene) {
  const std::string measure = scene["comparisons"][0]["measure"];
  std::set<std::size_t> drawn;
  for (std::size_t i = 0; i < scene["runs"].size(); ++i) {
    const Json& run = scene["runs"][i];
    const bool broken = run["outcome"] == "fell" || run["outcome"] == "came_apart" || run["outcome"] == "non_finite";
    const bool placed = run["outcome"] == "done" && run["errors"].contains(measure);
    if (!run["same_bits"] && (broken || placed)) drawn.insert(i);
  }
  return drawn;
}

// True if a run's mark in the section of its scene has the name of its engine and setting.
bool names_mark(const std::string& section, const Json& scene, std::size_t run) {
  const std::size_t mark = section.find("data-run=\"" + std::to_string(run) + "\"");
  const std::string engine = scene["runs"][run]["engine"], label = scene["runs"][run]["label"];
  const std::string name = " aria-label=\"" + engine + ": " + label;
  return section.substr(mark, section.find('>', mark) - mark).find(name) != std::string::npos;
}

// Towers and chains of every rung stand at the defaults.
TEST(Frontier, IsClimbedToTheEndAndShown) {
  const ScratchDirectory scratch;
  const CommandResult result = run_atoll({"sweep", "--frontier", "--quick", "--out", scratch.path("out")});
  ASSERT_EQ(result.status, 0) << result.err;
  const Json results = Json::parse(read_text(scratch.path("out") + "/results.json"));
  EXPECT_EQ(results["scenes"].size(), 0u);
  ASSERT_EQ(results["frontiers"].size(), 5u);
  for (const Json& frontier : results["frontiers"]) {
    SCOPED_TRACE(frontier["name"]);
    ASSERT_EQ(frontier["reaches"].size(), 1u);
    const Json& reach = frontier["reaches"][0];
    EXPECT_EQ(reach["engine"], "Atoll");
    EXPECT_EQ(reach["substeps"], 4);
    EXPECT_EQ(reach["reached"], frontier["rungs"].back());
    EXPECT_GT(reach["ms_per_step"], 0);
  }
  const std::optional<std::string> browser = find_browser();
  if (!browser) GTEST_SKIP() << without_browser;
  const LoadedPage loaded = load_page(*browser, scratch.path("out") + "/index.html", 900);
  EXPECT_EQ(loaded.console, "");
  EXPECT_EQ(count(loaded.document, "all: "), 5u + 1u);  // and once in the script
}

// A page with another one in it, on a screen of so many pixels, that tells how wide that one is once it is drawn, and
// what of it reaches beyond the screen but for what scrolls by itself. No window is made as narrow as a phone.
std::string page_on_screen(const std::string& page, int width) {
  std::string escaped;
  for (const char c : page) escaped += c == '&' ? "&amp;" : c == '"' ? "&quot;" : std::string(1, c);
  return "<!DOCTYPE html><body><iframe width=\"" + std::to_string(width) + "\" height=\"800\" srcdoc=\"" + escaped +
         R"re("></iframe><script>
  window.onload = () => {
    const page = document.querySelector('iframe').contentDocument, screen = page.documentElement.clientWidth;
    const beyond = [...page.body.querySelectorAll('*')].filter((element) =>
      !element.parentElement.closest('.scroll') && element.getBoundingClientRect().right > screen + 0.5);
    document.body.dataset.screen = screen;
    document.body.dataset.page = page.documentElement.scrollWidth;
    document.querySelector('iframe').remove();
    document.body.dataset.beyond = beyond.map((element) => element.tagName + '.' + element.classList).join();
  };
</script></body>)re";
}

TEST_F(LoadedSweepPage, FitsAPhonesScreen) {
  const std::regex shown(R"re(data-screen="(\d+)" data-page="(\d+)" data-beyond="([^"]*)")re");
  for (const int width : {390, 1280}) {
    SCOPED_TRACE(width);
    const std::string file = scratch_.write("screen.html", page_on_screen(read_text(page()), width));
    const std::string document = load_page(*browser_, file, 1400).document;
    std::smatch found;
    ASSERT_TRUE(std::regex_search(document, found, shown));
    // Less the bar that it is scrolled by, where there is one.
    EXPECT_LE(std::stoi(found[1]), width);
    EXPECT_GE(std::stoi(found[1]), width - 20);
    EXPECT_EQ(found[2], found[1]);
    EXPECT_EQ(found[3], "");
  }
}

TEST_F(SweepPage, NamesNothingOutsideItself) {
  const std::string text = read_text(page());
  const std::regex outside(
      R"re((src|href|action|srcset)\s*=\s*["']?(https?:|//)|@import|url\(|fetch\(|XMLHttpRequest)re");
  std::smatch found;
  EXPECT_FALSE(std::regex_search(text, found, outside)) << found.str();
  EXPECT_EQ(text.find("http://www.w3.org/2000/svg"), text.rfind("http"));
}

// And each of these with the place that it came from.
TEST_F(LoadedSweepPage, IsLinkedWithAPageThatPlaysEachScene) {
  const std::string document = load_page(*browser_, page(), 1200).document;
  for (std::size_t scene = 0; scene < results_["scenes"].size(); ++scene) {
    const std::string name = "view-" + std::to_string(scene) + ".html", place = "scene-" + std::to_string(scene);
    EXPECT_EQ(results_["scenes"][scene]["view"], name);
    EXPECT_EQ(count(document, "href=\"" + name + "\""), 1u);
    EXPECT_EQ(count(document, "id=\"" + place + "\""), 1u);
    const LoadedPage loaded = load_page(*browser_, scratch_.path("out") + "/" + name, 1200);
    EXPECT_EQ(loaded.console, "");
    EXPECT_EQ(count(loaded.document, "href=\"index.html#" + place + "\">Error against run time</a>"), 1u);
  }
}

TEST_F(LoadedSweepPage, DrawsEveryRunWithoutAConsoleMessage) {
  for (const int width : {1200, 390}) {
    SCOPED_TRACE(width);
    const LoadedPage loaded = load_page(*browser_, page(), width);
    ASSERT_EQ(loaded.status, 0);
    EXPECT_EQ(loaded.console, "");

    std::vector<std::string> sections;
    const std::regex opening(R"re(<section class="scene")re");
    for (std::sregex_iterator at(loaded.document.begin(), loaded.document.end(), opening), end; at != end; ++at) {
      sections.push_back(loaded.document.substr(static_cast<std::size_t>(at->position())));
      if (sections.size() > 1) {
        std::string& before = sections[sections.size() - 2];
        before.resize(before.size() - sections.back().size());
      }
    }
    ASSERT_EQ(sections.size(), results_["scenes"].size());
    for (std::size_t i = 0; i < sections.size(); ++i) {
      std::set<std::size_t> drawn;
      const std::regex point(R"re(<g class="point[^"]*" data-run="(\d+)" transform="translate\([-\d.]+ [-\d.]+\)")re");
      for (std::sregex_iterator at(sections[i].begin(), sections[i].end(), point), end; at != end; ++at) {
        drawn.insert(std::stoul((*at)[1]));
      }
      EXPECT_EQ(drawn, drawn_runs(results_["scenes"][i])) << results_["scenes"][i]["name"];
      // Without a pointer on them: each mark by its own name, those on fronts in the text as well.
      for (const std::size_t run : drawn) EXPECT_TRUE(names_mark(sections[i], results_["scenes"][i], run)) << run;
      EXPECT_NE(sections[i].find("Front of Atoll, from the fastest on: "), std::string::npos);
      EXPECT_GE(count(sections[i], "class=\"ring\""), 1u);
      EXPECT_GE(count(sections[i], "class=\"front atoll\" d=") + count(sections[i], "\" class=\"front atoll\""), 1u);
    }
    EXPECT_GE(count(loaded.document, "ringed: a default</li>"), results_["scenes"].size() - 1)
        << "the key of the marks";
    EXPECT_EQ(count(loaded.document, "NaN"), 0u);
    EXPECT_GE(count(loaded.document, "point hollow"), 2u);
    EXPECT_NE(loaded.document.find("took longer than 1 s"), std::string::npos);
    EXPECT_NE(loaded.document.find("Chaotic"), std::string::npos);
  }
}

}  // namespace
}  // namespace atl::test
