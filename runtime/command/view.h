#pragma once

#include <optional>
#include <string>

#include "output_file.h"
#include "run_options.h"

namespace atl::view {
class Film;
}

namespace atl::command {

/// Options of `atoll view`.
struct ViewOptions {
  SceneOptions scene;  ///< its text may also name a recording
  int threads = 1;
  Simd simd = Simd::Auto;
  std::string page;              ///< file to write, or ""
  std::string image;             ///< .png or .svg file to write, or ""
  std::string gltf;              ///< .glb or .gltf file to write, or ""
  std::string vtk;               ///< .vtkhdf file, of which the frames' files are named, or ""
  std::optional<int> step = {};  ///< of the image: the state after it, by default the last
  int stride = 1;                ///< steps a frame
  int from = 0;                  ///< step: the first frame is the state after it
  std::optional<int> to = {};    ///< step: the last one
  std::string place;             ///< what the page shows first, as after the # of its address
};

/// Declares the options, to be parsed into `options`, which has to outlive the parsing.
void add_view_options(CLI::App& command, ViewOptions& options);

/// `atoll view`: runs a scene or a recording, and writes the page that plays it, a picture, or what other programs
/// show. Throws SceneError and Failure.
void view(const ViewOptions& options);

/// The file of a page. Throws Failure in a build without one, and as OutputFile does.
OutputFile page_file(const char* option, const std::string& path);

/// Writes the page, or throws Failure.
void write_film(const OutputFile& file, view::Film& film);

}  // namespace atl::command
