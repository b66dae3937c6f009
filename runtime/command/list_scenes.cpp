#include "list_scenes.h"

#include <atoll/scene.h>

#include <iomanip>
#include <ostream>

namespace atl::command {

void list_scenes(std::ostream& out) {
  constexpr int width = 22;
  for (const BuiltinScene& scene : builtin_scenes()) {
    out << std::left << std::setw(width) << scene.name << scene.help << "\n";
    for (const SceneParameter& parameter : scene.parameters) {
      // Counts up to millions, all digits.
      out << "  " << std::setw(width - 2) << parameter.name << parameter.help << " (default " << std::setprecision(10)
          << parameter.value << ", " << (parameter.integer ? "integer in [" : "in [") << parameter.min << ", "
          << parameter.max << "])\n";
    }
  }
  out << "\nRun one with its parameters as in: atoll run " << builtin_scenes().back().name << ":";
  const char* separator = "";
  for (const SceneParameter& parameter : builtin_scenes().back().parameters) {
    out << separator << parameter.name << "=" << parameter.value;
    separator = ",";
  }
  out << "\n";
}

}  // namespace atl::command
