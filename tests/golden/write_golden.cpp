// Writes tests/determinism/golden_hashes.txt anew, after a change of results that is meant to be one.

#include <filesystem>
#include <fstream>
#include <iostream>

#include "golden/golden.h"
#include "state/hex.h"

namespace {

void write(std::ostream& out) {
  out << "# State hashes that every build must come to, whatever its compiler, threads and instruction set: hash, "
         "step,\n"
         "# settings, scene. After a change of results that is meant to be one, atoll_write_golden writes this anew.\n";
  for (const atl::test::GoldenCase& golden : atl::test::golden_cases()) {
    const atl::Scene scene = atl::test::golden_scene(golden);
    atl::divergence::VariantRun run(scene, {});
    for (const std::int64_t step : atl::test::golden_steps) {
      while (run.steps() < step) run.step();
      out << atl::hash_text(run.hash()) << " " << atl::test::golden_key(golden, step) << "\n";
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  const std::string path = atl::test::golden_path();
  if (argc > 1) {
    std::cerr << "usage: " << argv[0] << "\nwrites " << path << " anew\n";
    return 2;
  }
  try {
    const std::string temporary = path + ".new";
    std::ofstream file(temporary);
    write(file);
    file.close();
    if (!file) throw std::runtime_error("cannot write " + temporary);
    std::filesystem::rename(temporary, path);
  } catch (const std::exception& error) {
    std::cerr << "atoll_write_golden: " << error.what() << "\n";
    return 1;
  }
}
