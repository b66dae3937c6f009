#pragma once

#include <span>
#include <string>
#include <string_view>

namespace atl::scene {

/// The text on one line, as all that users wrote goes into messages: control characters, with which a text could move
/// a terminal's cursor, as \xNN, and "..." for the middle of more than 2000 bytes.
std::string printable(std::string_view text);
bool has_control_characters(std::string_view text);

/// The text in double quotes, printable, and cut off after 60 bytes.
std::string quote(std::string_view text);

/// The shortest decimal that reads back as the same number, whatever the locale; integers in full.
std::string number_text(double value);

/// "a, b or c".
std::string listed(std::span<const std::string_view> names);

/// " (did you mean "x"?)" with the name nearest to a mistyped one, or "" where none is near: nearest by
/// edit distance with transpositions counted as one edit.
std::string suggestion(std::string_view found, std::span<const std::string_view> names);

}  // namespace atl::scene
