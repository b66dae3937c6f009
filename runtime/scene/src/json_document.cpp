#include "json_document.h"

#include <atoll/scene.h>

#include <algorithm>
#include <cctype>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>

#include "words.h"

namespace atl::scene {
namespace {

// Values are destroyed recursively, so the depth of a hostile file has to have a limit.
constexpr std::size_t deepest = 64;

// Reads the text for nlohmann's parser and tells how far it got: the parser hands its events no position.
class TrackingIterator {
 public:
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;

  TrackingIterator(const char* at, const char** reached) : at_(at), reached_(reached) {}
  reference operator*() const { return *at_; }
  TrackingIterator& operator++() {
    *reached_ = ++at_;
    return *this;
  }
  TrackingIterator operator++(int) {
    const TrackingIterator before = *this;
    ++*this;
    return before;
  }
  bool operator==(const TrackingIterator& other) const { return at_ == other.at_; }
  bool operator!=(const TrackingIterator& other) const { return at_ != other.at_; }

 private:
  const char* at_;
  const char** reached_;
};

bool is_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '+' || c == '-' || c == '.'; }

// The number or literal at or just before a place where the lexer gave up, else the one character there.
std::string_view word_at(std::string_view text, std::size_t at) {
  std::size_t begin = at, end = at;
  while (begin > 0 && is_word(text[begin - 1])) --begin;
  while (end < text.size() && is_word(text[end])) ++end;
  return begin < end ? text.substr(begin, end - begin) : text.substr(at, 1);
}

// Turns nlohmann's "syntax error while parsing value - unexpected ']'; expected ..." into our words.
std::string syntax_words(const std::string& what, std::string_view text, std::size_t at) {
  constexpr std::string_view unexpected = "unexpected ", last_read = "; last read: '", expected = "; expected ";
  const std::size_t dash = what.find(" - ");
  std::string detail = dash == std::string::npos ? what : what.substr(dash + 3);
  if (detail.starts_with(unexpected)) {
    detail.erase(0, unexpected.size());
    const std::size_t split = detail.find(expected);
    return "found " + (split == std::string::npos ? detail + ", expected valid JSON"
                                                  : detail.replace(split, expected.size(), ", expected "));
  }
  if (detail.starts_with("invalid literal") || detail.starts_with("invalid number")) {
    return "found " + quote(word_at(text, at)) + ", expected valid JSON";
  }
  return "found an " + detail.substr(0, detail.find(last_read)) + ", expected valid JSON";
}

// Builds the document from nlohmann's events.
class Builder {
 public:
  Builder(std::string_view text, JsonDocument& document)
      : text_(text), reached_(text.data()), counted_(text.data()), document_(document) {}

  void build() {
    const TrackingIterator begin(text_.data(), &reached_), end(text_.data() + text_.size(), &reached_);
    nlohmann::json::sax_parse(begin, end, this);
  }

  // The events, under the names that nlohmann's SAX interface gives them.
  bool null() {
    add();
    return true;
  }
  bool boolean(bool value) {
    add().data = value;
    return true;
  }
  bool number_integer(std::int64_t value) { return add_number(static_cast<double>(value)); }
  bool number_unsigned(std::uint64_t value) { return add_number(static_cast<double>(value)); }
  bool number_float(double value, const std::string&) { return add_number(value); }
  bool string(std::string& value) {
    add().data = std::move(value);
    return true;
  }
  bool binary(nlohmann::json::binary_t&) { return false; }  // not in text
  bool start_array(std::size_t) {
    open().data.emplace<JsonValue::Array>();
    return true;
  }
  bool end_array() {
    open_.pop_back();
    return true;
  }
  bool start_object(std::size_t) {
    open().data.emplace<JsonValue::Object>();
    keys_.emplace_back();
    return true;
  }
  bool end_object() {
    open_.pop_back();
    keys_.pop_back();
    return true;
  }

  bool key(const std::string& name) {
    auto& members = std::get<JsonValue::Object>(open_.back()->data);
    if (!keys_.back().insert(name).second) {
      std::string pointer = document_.pointer_to(*open_.back());
      append_key(pointer, name);
      throw SceneError(document_.origin + ":" + std::to_string(line()) + ": " + pointer +
                       ": found the key a second time, expected every key of an object once");
    }
    members.push_back({name, {}});
    return true;
  }

  bool parse_error(std::size_t position, const std::string& token, const nlohmann::json::exception& error) {
    // The last character read is the one that could not be; past the end of the text it is the end.
    const std::size_t at = std::min(position == 0 ? 0 : position - 1, text_.size());
    const std::string_view before = text_.substr(0, at);
    const std::size_t line_start = before.rfind('\n') + 1;  // npos + 1 is 0
    const auto newlines = std::count(before.begin(), before.end(), '\n');
    constexpr int number_overflow = 406;
    throw SceneError(
        document_.origin + ":" + std::to_string(newlines + 1) + ":" + std::to_string(at - line_start + 1) + ": " +
        (error.id == number_overflow ? "found " + quote(token) + ", expected a number that a double can hold"
                                     : syntax_words(error.what(), text_, at)));
  }

 private:
  std::int32_t line() {
    line_ += static_cast<std::int32_t>(std::count(counted_, reached_, '\n'));
    counted_ = reached_;
    return line_;
  }

  bool add_number(double value) {
    // The lexer has read one character past a number, which may be the end of its line.
    if (reached_ > counted_ && reached_[-1] == '\n') --reached_;
    add().data = value;
    return true;
  }

  // The place of the value that was just read.
  JsonValue& add() {
    JsonValue* value = &document_.root;
    if (!open_.empty()) {
      auto* array = std::get_if<JsonValue::Array>(&open_.back()->data);
      value = array != nullptr ? &array->emplace_back() : &std::get<JsonValue::Object>(open_.back()->data).back().value;
    }
    value->line = line();
    return *value;
  }

  // The same for one that others go into. Its address stays good: its parent grows again only after it is closed.
  JsonValue& open() {
    if (open_.size() == deepest) {
      throw SceneError(document_.origin + ":" + std::to_string(line()) + ": found values nested more than " +
                       std::to_string(deepest) + " deep, expected a scene, which is not");
    }
    open_.push_back(&add());
    return *open_.back();
  }

  std::string_view text_;
  const char* reached_;
  const char* counted_;
  std::int32_t line_ = 1;
  JsonDocument& document_;
  std::vector<JsonValue*> open_;
  std::vector<std::set<std::string>> keys_;  // of the open objects
};

bool find_pointer(const JsonValue& from, const JsonValue& value, std::string& pointer) {
  if (&from == &value) return true;
  const std::size_t length = pointer.size();
  if (const auto* array = std::get_if<JsonValue::Array>(&from.data)) {
    for (std::size_t i = 0; i < array->size(); ++i) {
      pointer += '/';
      pointer += std::to_string(i);
      if (find_pointer((*array)[i], value, pointer)) return true;
      pointer.resize(length);
    }
  } else if (const auto* object = std::get_if<JsonValue::Object>(&from.data)) {
    for (const JsonValue::Member& member : *object) {
      append_key(pointer, member.key);
      if (find_pointer(member.value, value, pointer)) return true;
      pointer.resize(length);
    }
  }
  return false;
}

}  // namespace

void append_key(std::string& pointer, std::string_view key) {
  pointer += '/';
  for (const char c : key) {
    if (c == '~') {
      pointer += "~0";
    } else if (c == '/') {
      pointer += "~1";
    } else if (static_cast<unsigned char>(c) < 0x20) {
      constexpr const char* hex = "0123456789abcdef";
      pointer += {'\\', 'u', '0', '0', hex[c >> 4], hex[c & 15]};
    } else {
      pointer += c;
    }
  }
}

std::string JsonDocument::pointer_to(const JsonValue& value) const {
  std::string pointer;
  find_pointer(root, value, pointer);
  return pointer;
}

JsonDocument parse_json(std::string_view text, const std::string& origin) {
  JsonDocument document{.origin = origin, .root = {}};
  Builder(text, document).build();
  return document;
}

}  // namespace atl::scene
