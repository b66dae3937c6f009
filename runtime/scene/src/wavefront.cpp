#include "wavefront.h"

#include <atoll/scene.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include "words.h"

namespace atl::scene {
namespace {

constexpr std::string_view blanks = " \t\r";

// Takes the next word off the front of a line; "" at its end.
std::string_view next_word(std::string_view& line) {
  const std::size_t begin = std::min(line.find_first_not_of(blanks), line.size());
  line.remove_prefix(begin);
  const std::size_t length = std::min(line.find_first_of(blanks), line.size());
  const std::string_view word = line.substr(0, length);
  line.remove_prefix(length);
  return word;
}

class Parser {
 public:
  explicit Parser(const std::string& origin) : origin_(origin) {}

  void read(std::string_view text) {
    while (!text.empty()) {
      ++line_;
      const std::size_t end = std::min(text.find('\n'), text.size());
      read_line(text.substr(0, end));
      text.remove_prefix(std::min(end + 1, text.size()));
    }
    if (result_.vertices.empty()) fail("no vertex", "lines \"v X Y Z\"");
  }

  Wavefront take() { return std::move(result_); }

 private:
  void read_line(std::string_view line) {
    line = line.substr(0, line.find('#'));
    const std::string_view keyword = next_word(line);
    if (keyword == "v") {
      const double x = number(next_word(line));
      const double y = number(next_word(line));
      const double z = number(next_word(line));
      result_.vertices.emplace_back(x, y, z);
    } else if (keyword == "f") {
      read_face(line);
    }
  }

  void read_face(std::string_view line) {
    corners_.clear();
    for (std::string_view word = next_word(line); !word.empty(); word = next_word(line)) {
      corners_.push_back(vertex(word.substr(0, word.find('/'))));
    }
    if (corners_.size() < 3) fail("a face of " + std::to_string(corners_.size()) + " corners", "at least 3");
    for (std::size_t i = 1; i + 1 < corners_.size(); ++i) {
      result_.triangles.push_back({corners_[0], corners_[i], corners_[i + 1]});
    }
  }

  double number(std::string_view word) const {
    double value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value)) {
      fail(quote(word), "three finite numbers after v");
    }
    return value;
  }

  // Counted from 1, or from the last vertex back from -1.
  std::uint32_t vertex(std::string_view word) const {
    const auto count = static_cast<std::int64_t>(result_.vertices.size());
    std::int64_t value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    const bool whole = error == std::errc() && end == word.data() + word.size();
    if (!whole || value == 0 || value > count || value < -count) {
      fail("vertex " + quote(word), "a number in [1, " + std::to_string(count) + "], or below 0 to count back");
    }
    return static_cast<std::uint32_t>(value > 0 ? value - 1 : count + value);
  }

  [[noreturn]] void fail(const std::string& found, const std::string& expected) const {
    throw SceneError(origin_ + ":" + std::to_string(line_) + ": found " + found + ", expected " + expected);
  }

  const std::string& origin_;
  Wavefront result_;
  std::vector<std::uint32_t> corners_;
  int line_ = 0;
};

}  // namespace

Wavefront parse_wavefront(std::string_view text, const std::string& origin) {
  Parser parser(origin);
  parser.read(text);
  return parser.take();
}

}  // namespace atl::scene
