#include "reader.h"

#include <atoll/scene.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <span>

#include "words.h"

namespace atl::scene {
namespace {

std::string described(const JsonValue& value) {
  struct Visitor {
    std::string operator()(std::monostate) const { return "null"; }
    std::string operator()(bool b) const { return b ? "true" : "false"; }
    std::string operator()(double x) const { return number_text(x); }
    std::string operator()(const std::string& s) const { return quote(s); }
    std::string operator()(const JsonValue::Array& a) const {
      return a.empty() ? "an empty array" : "an array of " + std::to_string(a.size());
    }
    std::string operator()(const JsonValue::Object&) const { return "an object"; }
  };
  return std::visit(Visitor{}, value.data);
}

[[noreturn]] void refuse(const JsonDocument& document, const JsonValue& value, const std::string& pointer,
                         const std::string& words) {
  throw SceneError(document.origin + ":" + std::to_string(value.line) + ": " + (pointer.empty() ? "" : pointer + ": ") +
                   words);
}

[[noreturn]] void refuse(const JsonDocument& document, const JsonValue& value, const std::string& pointer,
                         const std::string& found, const std::string& expected) {
  refuse(document, value, pointer, "found " + found + ", expected " + expected);
}

}  // namespace

std::string Range::words() const {
  const bool has_min = std::isfinite(min), has_max = std::isfinite(max);
  if (has_min && has_max) return (above_min ? " in (" : " in [") + number_text(min) + ", " + number_text(max) + "]";
  if (has_min) return (above_min ? " > " : " >= ") + number_text(min);
  return has_max ? " <= " + number_text(max) : "";
}

double Reader::number(const Range& range) const {
  const double* x = std::get_if<double>(&value_->data);
  if (x == nullptr || !range.contains(*x)) expected("a number" + range.words());
  return *x;
}

int Reader::integer(int min, int max) const {
  const Range range = between(min, max);
  const double* x = std::get_if<double>(&value_->data);
  if (x == nullptr || !range.contains(*x) || std::trunc(*x) != *x) expected("an integer" + range.words());
  return static_cast<int>(*x);
}

bool Reader::boolean() const {
  const bool* b = std::get_if<bool>(&value_->data);
  if (b == nullptr) expected("true or false");
  return *b;
}

const std::string& Reader::string() const {
  const auto* s = std::get_if<std::string>(&value_->data);
  if (s == nullptr) expected("a string");
  return *s;
}

std::size_t Reader::choice(std::initializer_list<std::string_view> names) const {
  const std::span<const std::string_view> all(names.begin(), names.size());
  const auto* s = std::get_if<std::string>(&value_->data);
  const auto at = s == nullptr ? all.end() : std::find(all.begin(), all.end(), *s);
  if (at == all.end()) expected(listed(all) + (s == nullptr ? "" : suggestion(*s, all)));
  return static_cast<std::size_t>(at - all.begin());
}

template <std::size_t size>
std::array<double, size> Reader::numbers(const char* what, const Range& range) const {
  const JsonValue::Array& elements = array(what);
  if (elements.size() != size) expected(what);
  std::array<double, size> result{};
  for (std::size_t i = 0; i < size; ++i) result[i] = element(i).number(range);
  return result;
}
template std::array<double, 2> Reader::numbers(const char*, const Range&) const;
template std::array<double, 3> Reader::numbers(const char*, const Range&) const;
template std::array<double, 4> Reader::numbers(const char*, const Range&) const;
template std::array<double, 6> Reader::numbers(const char*, const Range&) const;

const JsonValue::Array& Reader::array(const std::string& what) const {
  const auto* elements = std::get_if<JsonValue::Array>(&value_->data);
  if (elements == nullptr) expected(what);
  return *elements;
}

std::size_t Reader::size(const char* what) const { return array(what).size(); }

Reader Reader::element(std::size_t i) const { return {*document_, std::get<JsonValue::Array>(value_->data).at(i)}; }

const JsonValue::Object& Reader::members() const {
  const auto* object = std::get_if<JsonValue::Object>(&value_->data);
  if (object == nullptr) expected("an object");
  return *object;
}

void Reader::only_keys(std::span<const std::string_view> all) const {
  for (const JsonValue::Member& member : members()) {
    if (std::find(all.begin(), all.end(), member.key) != all.end()) continue;
    this->member(member).fail("the unknown key " + quote(member.key), listed(all) + suggestion(member.key, all));
  }
}

std::optional<Reader> Reader::find(std::string_view key) const {
  for (const JsonValue::Member& member : members()) {
    if (member.key == key) return this->member(member);
  }
  return std::nullopt;
}

Reader Reader::at(std::string_view key, const std::string& expected) const {
  if (const auto found = find(key)) return *found;
  fail_at(key, "nothing", expected);
}

void Reader::fail(const std::string& found, const std::string& expected) const {
  refuse(*document_, *value_, document_->pointer_to(*value_), found, expected);
}

void Reader::fail_at(std::string_view key, const std::string& found, const std::string& expected) const {
  if (const auto there = find(key)) there->fail(found, expected);
  std::string pointer = document_->pointer_to(*value_);
  append_key(pointer, key);
  refuse(*document_, *value_, pointer, found, expected);
}

void Reader::complain(const std::string& words) const {
  refuse(*document_, *value_, document_->pointer_to(*value_), words);
}

void Reader::expected(const std::string& what) const { fail(described(*value_), what); }

Vector3 read_vector(const Reader& in, const Range& range) {
  const auto [x, y, z] = in.numbers<3>("an array of three numbers, [x, y, z]", range);
  return {x, y, z};
}

std::uint64_t read_unsigned(const Reader& in) {
  constexpr double largest = 1ull << 53;  // up to which a double holds each
  if (in.is<std::string>()) {
    const std::string& digits = in.string();
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (error != std::errc() || end != digits.data() + digits.size()) in.expected("an integer >= 0 below 2^64");
    return value;
  }
  const double value = in.number(between(0, largest));
  if (std::trunc(value) != value) in.expected("an integer >= 0");
  return static_cast<std::uint64_t>(value);
}

void get(const Reader& in, std::string_view key, double& target, const Range& range) {
  if (const auto found = in.find(key)) target = found->number(range);
}

void get(const Reader& in, std::string_view key, std::optional<double>& target, const Range& range) {
  if (const auto found = in.find(key)) target = found->number(range);
}

void get(const Reader& in, std::string_view key, int& target, int min, int max) {
  if (const auto found = in.find(key)) target = found->integer(min, max);
}

void get(const Reader& in, std::string_view key, bool& target) {
  if (const auto found = in.find(key)) target = found->boolean();
}

void read_name(const Reader& in, std::string& name) {
  const auto found = in.find("name");
  if (!found) return;
  name = found->string();
  if (has_control_characters(name)) found->expected("a name without control characters");
}

void get(const Reader& in, std::string_view key, std::uint64_t& target) {
  if (const auto found = in.find(key)) target = read_unsigned(*found);
}

void get(const Reader& in, std::string_view key, Vector3& target, const Range& range) {
  if (const auto found = in.find(key)) target = read_vector(*found, range);
}

}  // namespace atl::scene
