#include "words.h"

#include <atoll/scene.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <vector>

namespace atl::scene {
namespace {

constexpr std::size_t longest_quote = 60;
constexpr std::size_t longest_message = 2000;

// Optimal string alignment (Damerau-Levenshtein without overlapping edits), on three rows of the table.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before(b.size() + 1), above(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) above[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({above[j] + 1, row[j - 1] + 1, above[j - 1] + (a[i - 1] != b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) row[j] = std::min(row[j], before[j - 2] + 1);
    }
    std::swap(before, above);
    std::swap(above, row);
  }
  return above[b.size()];
}

// The most bytes up to `length` that leave the characters of UTF-8 whole.
std::size_t whole_characters(std::string_view text, std::size_t length) {
  if (length >= text.size()) return text.size();
  while (length > 0 && (static_cast<unsigned char>(text[length]) & 0xc0) == 0x80) --length;
  return length;
}

// The control characters of Unicode are those below 0x20 and from 0x7f to 0x9f, which UTF-8 writes as 0xc2 and a byte.
bool is_control(std::string_view text, std::size_t at) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  if (byte(at) < 0x20 || byte(at) == 0x7f) return true;
  return byte(at) >= 0x80 && byte(at) < 0xa0 && at > 0 && byte(at - 1) == 0xc2;
}

std::string escaped(std::string_view text) {
  constexpr const char* hex = "0123456789abcdef";
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (!is_control(text, i)) {
      result += text[i];
      continue;
    }
    const auto byte = static_cast<unsigned char>(text[i]);
    if (byte >= 0x80) result.pop_back();
    result += {'\\', 'x', hex[byte >> 4], hex[byte & 15]};
  }
  return result;
}

}  // namespace

bool has_control_characters(std::string_view text) { return escaped(text) != text; }

std::string printable(std::string_view text) {
  if (text.size() <= longest_message) return escaped(text);
  return escaped(text.substr(0, whole_characters(text, longest_message / 2))) + "..." +
         escaped(text.substr(whole_characters(text, text.size() - longest_message / 4)));
}

std::string quote(std::string_view text) {
  const std::size_t length = whole_characters(text, longest_quote);
  return "\"" + escaped(text.substr(0, length)) + (length < text.size() ? "...\"" : "\"");
}

std::string number_text(double value) {
  constexpr double max_integer = 1e15;  // shown with all digits
  if (std::trunc(value) == value && std::abs(value) < max_integer) {
    return std::to_string(static_cast<long long>(value));
  }
  std::array<char, 32> digits;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
  return {digits.data(), end};
}

std::string listed(std::span<const std::string_view> names) {
  std::string result;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i > 0) result += i + 1 < names.size() ? ", " : " or ";
    result += names[i];
  }
  return result;
}

std::string suggestion(std::string_view found, std::span<const std::string_view> names) {
  if (found.size() > longest_quote) return "";
  std::size_t min = std::max<std::size_t>(1, found.size() / 3) + 1;
  std::string_view nearest;
  for (const std::string_view name : names) {
    // A name that starts with what was typed is near however much is missing.
    const bool starts = found.size() >= 3 && name.starts_with(found);
    const std::size_t distance = starts ? 1 : edit_distance(found, name);
    if (distance < min) {
      min = distance;
      nearest = name;
    }
  }
  return nearest.empty() ? "" : " (did you mean " + quote(nearest) + "?)";
}

}  // namespace atl::scene

namespace atl {

SceneError::SceneError(const std::string& message) : Error(scene::printable(message)) {}

}  // namespace atl
