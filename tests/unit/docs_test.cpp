// The READMEs and the guide tell the truth about the repository: links lead somewhere, functions are in the files that
// are named, and numbers and packages are those of the code.

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace atl {
namespace {

namespace fs = std::filesystem;

const fs::path root = ATOLL_SOURCE_DIR;

std::string read(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::vector<fs::path> readmes() {
  std::vector<fs::path> found = {root / "README.md", root / "CONTRIBUTING.md", root / "CHANGELOG.md"};
  for (const char* folder : {"jobs", "collision", "solver", "runtime", "tests", "perf"}) {
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root / folder)) {
      if (entry.path().extension() == ".md") found.push_back(entry.path());
    }
  }
  return found;
}

// Without blocks of code, in which # begins a comment and brackets are no links.
std::string prose_of(const fs::path& path) {
  std::istringstream in(read(path));
  std::string prose, line;
  bool code = false;
  while (std::getline(in, line)) {
    if (line.starts_with("```")) code = !code;
    if (!code && !line.starts_with("```")) prose += line + "\n";
  }
  return prose;
}

// The anchor that GitHub gives a heading: small letters, hyphens for spaces, no other marks.
std::string anchor_of(const std::string& heading) {
  std::string anchor;
  for (const char c : heading) {
    const auto letter = static_cast<unsigned char>(c);
    if (c == ' ' || c == '-') {
      anchor += '-';
    } else if (std::isalnum(letter) || c == '_' || letter >= 0x80) {
      anchor += static_cast<char>(std::tolower(letter));
    }
  }
  return anchor;
}

std::set<std::string> anchors_in(const fs::path& path) {
  std::set<std::string> anchors;
  std::istringstream in(prose_of(path));
  std::string line;
  while (std::getline(in, line)) {
    if (!line.starts_with("#")) continue;
    anchors.insert(anchor_of(line.substr(line.find_first_not_of('#') + 1)));
  }
  return anchors;
}

TEST(Docs, LinksLeadSomewhere) {
  const std::regex link(R"(\]\(([^)\s]+)\))");
  std::size_t links = 0;
  for (const fs::path& readme : readmes()) {
    const std::string prose = prose_of(readme);
    for (std::sregex_iterator i(prose.begin(), prose.end(), link), end; i != end; ++i) {
      const std::string target = (*i)[1];
      if (target.find("://") != std::string::npos) continue;
      ++links;
      const std::size_t hash = target.find('#');
      const std::string file = target.substr(0, hash);
      const fs::path path = file.empty() ? readme : readme.parent_path() / file;
      EXPECT_TRUE(fs::exists(path)) << readme << ": " << target;
      if (hash == std::string::npos || path.extension() != ".md") continue;
      EXPECT_TRUE(anchors_in(path).contains(target.substr(hash + 1))) << readme << ": " << target;
    }
  }
  EXPECT_GT(links, 20u);
}

// Lines "World::step   runtime/step/step.cpp" of the guide's drawings of a step.
TEST(Docs, TheCallsOfAStepAreWhereTheGuideSays) {
  std::istringstream in(read(root / "runtime/guide/architecture.md"));
  const std::regex call(R"(\s*(?:\w+::)*(~?\w+)(?:\(\w*\))?\s+([\w/.-]+\.(?:cpp|h))(?:\s.*)?)");
  std::string line;
  bool drawing = false;
  int calls = 0;
  while (std::getline(in, line)) {
    if (line.starts_with("```")) {
      drawing = line == "```text";
      continue;
    }
    if (!drawing) continue;
    std::smatch match;
    ASSERT_TRUE(std::regex_match(line, match, call)) << line;
    ASSERT_TRUE(fs::is_regular_file(root / match[2].str())) << line;
    const std::regex name("\\b" + match[1].str() + "\\b");
    EXPECT_TRUE(std::regex_search(read(root / match[2].str()), name)) << line;
    ++calls;
  }
  EXPECT_GT(calls, 20);
}

// The files whose paths end like that.
std::vector<fs::path> files_named(const std::string& name) {
  std::vector<fs::path> found;
  for (const char* folder : {"jobs", "collision", "solver", "runtime"}) {
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root / folder)) {
      if (entry.path().generic_string().ends_with("/" + name)) found.push_back(entry.path());
    }
  }
  return found;
}

// A number that the code defines is followed by a comment which names it: 0.43%<!-- tuning.h column_penetration -->.
// Between the two there may be a percent sign or other units, and a word.
TEST(Docs, NumbersAreThoseOfTheCode) {
  const std::regex quoted(R"(([0-9][0-9.e+-]*)(?:/([0-9]+))?(%| mm)?[^<>\n0-9]{0,12}<!-- ([\w/-]+\.h) (\w+) -->)");
  std::size_t marks = 0, numbers = 0;
  for (const fs::path& readme : readmes()) {
    const std::string text = prose_of(readme);
    const std::regex mark(R"([^`]<!-- [\w/-]+\.h \w+ -->)");
    marks += static_cast<std::size_t>(std::distance(std::sregex_iterator(text.begin(), text.end(), mark), {}));
    for (std::sregex_iterator i(text.begin(), text.end(), quoted), end; i != end; ++i) {
      const std::smatch& match = *i;
      ++numbers;
      double value = std::stod(match[1]);
      if (match[2].matched) value /= std::stod(match[2]);
      if (match[3] == "%") value *= 0.01;
      if (match[3] == " mm") value *= 1e-3;
      const std::vector<fs::path> headers = files_named(match[4]);
      ASSERT_EQ(headers.size(), 1u) << readme << ": " << match[0];
      const std::string header = read(headers[0]);
      const std::regex definition("\\b" + match[5].str() + R"( = ([0-9][0-9.e+-]*)f?(?: / ([0-9.]+))?f?;)");
      std::smatch defined;
      ASSERT_TRUE(std::regex_search(header, defined, definition)) << readme << ": " << match[0];
      double right = std::stod(defined[1]);
      if (defined[2].matched) right /= std::stod(defined[2]);
      EXPECT_NEAR(value, right, 1e-9 * std::abs(right)) << readme << ": " << match[0];
    }
  }
  EXPECT_EQ(numbers, marks) << "a comment follows no number";
  EXPECT_GT(numbers, 20u);
}

TEST(Docs, TheGuideNamesThePackagesThatTheBuildNeeds) {
  const std::string setup = read(root / "runtime/setup.sh");
  const std::size_t begin = setup.find("\npackages=(") + 11, end = setup.find(')', begin);
  ASSERT_NE(end, std::string::npos);
  const std::string page = read(root / "runtime/guide/install.md");
  const std::size_t from = page.find("apt-get install"), to = page.find("\ncmake", from);
  ASSERT_NE(to, std::string::npos);
  const std::string named = page.substr(from, to - from);
  std::istringstream packages(setup.substr(begin, end - begin));
  for (std::string package; packages >> package;) EXPECT_NE(named.find(package), std::string::npos) << package;
}

}  // namespace
}  // namespace atl
