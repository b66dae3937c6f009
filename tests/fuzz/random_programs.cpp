// Random programs of calls, each with 1 and 2 threads, by the portable kernels and by this machine's best: all have to
// come to the same bits.

#include <array>
#include <chrono>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <random>
#include <string_view>
#include <vector>

#include "program.h"

int main(int argc, char** argv) {
  using namespace atl;
  const bool first_kinds = argc == 5 && std::string_view(argv[4]) == "first-kinds";
  if (argc != 4 && !first_kinds) {
    std::cerr << "usage: " << argv[0] << " PROGRAMS CALLS FIRST_SEED [first-kinds]\n";
    return 2;
  }
  const auto programs = std::strtoul(argv[1], nullptr, 10);
  const int calls = std::atoi(argv[2]);
  const auto first = std::strtoul(argv[3], nullptr, 10);
  constexpr std::array<fuzz::Variant, 4> variants = {{{.threads = 1, .simd = Simd::Auto},
                                                      {.threads = 2, .simd = Simd::Auto},
                                                      {.threads = 1, .simd = Simd::Portable},
                                                      {.threads = 2, .simd = Simd::Portable}}};
  fuzz::ProgramResult sum;
  unsigned long faults = 0;
  for (unsigned long seed = first; seed < first + programs; ++seed) {
    std::mt19937 random(static_cast<std::mt19937::result_type>(seed));
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(calls) * 64);
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
    const fuzz::Numbers numbers = seed % 4 == 3 ? fuzz::Numbers::Any : fuzz::Numbers::Usual;
    try {
      const fuzz::ProgramLimits limits = {
          .calls = calls, .steps = 2 * calls, .first_kinds = first_kinds, .trace = programs == 1};
      const fuzz::ProgramResult result = fuzz::run_program(bytes, numbers, variants, limits);
      sum.calls += result.calls;
      sum.steps += result.steps;
      sum.refused += result.refused;
      sum.quarantined += result.quarantined;
    } catch (const std::exception& error) {
      std::cout << "program " << seed << ": " << error.what() << std::endl;
      ++faults;
    }
  }
  std::cout << programs << " programs of " << sum.calls << " calls and " << sum.steps << " steps, " << sum.refused
            << " calls refused, " << sum.quarantined << " bodies in quarantine, " << faults << " programs at fault\n";
  return faults == 0 ? 0 : 1;
}
