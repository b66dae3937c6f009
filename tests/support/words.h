#pragma once

#include <sstream>
#include <string>
#include <vector>

namespace atl::test {

/// The parts of a text between separators: the words of a command, or a list that reads better as one.
inline std::vector<std::string> words_of(const std::string& text, char separator = ' ') {
  std::vector<std::string> words;
  std::istringstream stream(text);
  for (std::string word; std::getline(stream, word, separator);) words.push_back(word);
  return words;
}

}  // namespace atl::test
