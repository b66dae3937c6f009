#pragma once
/// Shared by the programs that write seed inputs.

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <ios>
#include <iterator>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace atl::fuzz::seeds {

namespace fs = std::filesystem;
using Input = std::vector<std::uint8_t>;

inline Input read(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

inline void write(const fs::path& path, const Input& input) {
  fs::create_directories(path.parent_path());
  std::ofstream stream(path, std::ios::binary);
  stream.write(reinterpret_cast<const char*>(input.data()), static_cast<std::streamsize>(input.size()));
  if (!stream.flush()) throw std::runtime_error("cannot write " + path.string());
}

inline Input text(const std::string& words) { return {words.begin(), words.end()}; }

/// The name of a built-in scene without its parameters.
inline std::string plain(const std::string& name) { return name.substr(0, name.find(':')); }

/// Scene seeds (scene_seeds.cpp): built-in scenes as files and by name, files of all keys, files wrong in one place
/// each, and those given.
void write_scenes(const fs::path& folder, std::span<char*> files);

}  // namespace atl::fuzz::seeds
