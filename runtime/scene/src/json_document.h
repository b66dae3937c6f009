#pragma once

#include <atoll/scene.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace atl::scene {

/// A JSON value that remembers its line, so that an error found long after parsing can name it.
struct JsonValue {
  struct Member;
  using Array = std::vector<JsonValue>;
  using Object = std::vector<Member>;  ///< in the file's order; keys are unique

  std::variant<std::monostate, bool, double, std::string, Array, Object> data;
  std::int32_t line = 1;
};

struct JsonValue::Member {
  std::string key;
  JsonValue value;
};

/// A parsed file, the name it goes by in messages, and which files it may name.
struct JsonDocument {
  std::string origin;
  JsonValue root;
  MeshFiles mesh_files = MeshFiles::BelowScene;

  /// RFC 6901 pointer to a value of this document. Walks the document, so it is for errors only.
  std::string pointer_to(const JsonValue& value) const;
};

/// Appends "/key", with ~ and / escaped as RFC 6901 says, and control characters as in a JSON string.
void append_key(std::string& pointer, std::string_view key);

/// Strict JSON. Throws SceneError with line and column for a syntax error and for a number that no
/// double holds, with line and pointer for a key that an object has twice.
JsonDocument parse_json(std::string_view text, const std::string& origin);

}  // namespace atl::scene
