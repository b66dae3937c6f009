#pragma once

#include <atoll/types.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "json_document.h"

namespace atl::scene {

/// The valid values of a number, and how to say so.
struct Range {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool above_min = false;  ///< min itself is not valid

  bool contains(double value) const { return (above_min ? value > min : value >= min) && value <= max; }
  /// "", " > 0", " >= 0" or " in (0, 1]", to follow the kind of number.
  std::string words() const;
};

inline constexpr Range any_number{};
constexpr Range at_least(double min) { return {.min = min}; }
constexpr Range above(double min) { return {.min = min, .above_min = true}; }
constexpr Range between(double min, double max) { return {.min = min, .max = max}; }
constexpr Range above_up_to(double min, double max) { return {.min = min, .max = max, .above_min = true}; }

/// One value of a scene file, read as what the schema says it is. Whatever does not fit throws a
/// SceneError of one line: file, line, JSON pointer, what was found, what was expected. Copies are
/// cheap; the document must outlive them.
class Reader {
 public:
  explicit Reader(const JsonDocument& document) : Reader(document, document.root) {}

  /// True if it is a std::string, or, of null, a std::monostate.
  template <typename T>
  bool is() const {
    return std::holds_alternative<T>(value_->data);
  }

  bool is_number(double value) const {
    const double* number = std::get_if<double>(&value_->data);
    return number != nullptr && *number == value;
  }

  double number(const Range& range = any_number) const;
  int integer(int min, int max) const;
  bool boolean() const;
  const std::string& string() const;
  /// A string out of these; its index.
  std::size_t choice(std::initializer_list<std::string_view> names) const;
  /// An array of `size` numbers, each in the range. `what` names it, as "[x, y, z]".
  template <std::size_t size>
  std::array<double, size> numbers(const char* what, const Range& range = any_number) const;

  /// The file that the value is in.
  const JsonDocument& document() const { return *document_; }

  /// An array's size; `what` names what is expected of it.
  std::size_t size(const char* what) const;
  Reader element(std::size_t i) const;

  /// Refuses everything but an object, and every key that is not among these.
  void only_keys(std::initializer_list<std::string_view> keys) const {
    only_keys(std::span(keys.begin(), keys.size()));
  }
  void only_keys(std::span<const std::string_view> keys) const;
  /// The members of an object whose keys are names of the user's choice.
  const JsonValue::Object& members() const;
  Reader member(const JsonValue::Member& member) const { return {*document_, member.value}; }
  bool has(std::string_view key) const { return find(key).has_value(); }
  std::optional<Reader> find(std::string_view key) const;
  /// A member that has to be there; `expected` says what it should be.
  Reader at(std::string_view key, const std::string& expected) const;

  [[noreturn]] void fail(const std::string& found, const std::string& expected) const;
  /// The same, about the member `key`, which may be missing.
  [[noreturn]] void fail_at(std::string_view key, const std::string& found, const std::string& expected) const;
  /// The same, with words of its own for what was found and expected.
  [[noreturn]] void complain(const std::string& words) const;
  /// The same, with the value itself as what was found.
  [[noreturn]] void expected(const std::string& what) const;

 private:
  Reader(const JsonDocument& document, const JsonValue& value) : document_(&document), value_(&value) {}

  const JsonValue::Array& array(const std::string& what) const;

  const JsonDocument* document_;
  const JsonValue* value_;
};

Vector3 read_vector(const Reader& in, const Range& range = any_number);
/// An integer that is not negative: a number, or where it has more than 53 bits a string of its digits.
std::uint64_t read_unsigned(const Reader& in);

// Overwrite the target with a member where the key is there, and leave its default where it isn't.
void get(const Reader& in, std::string_view key, double& target, const Range& range = any_number);
void get(const Reader& in, std::string_view key, std::optional<double>& target, const Range& range = any_number);
void get(const Reader& in, std::string_view key, int& target, int min, int max);
void get(const Reader& in, std::string_view key, bool& target);
/// A name goes into reports as it is, so it must not have control characters.
void read_name(const Reader& in, std::string& name);
void get(const Reader& in, std::string_view key, std::uint64_t& target);
void get(const Reader& in, std::string_view key, Vector3& target, const Range& range = any_number);

}  // namespace atl::scene
