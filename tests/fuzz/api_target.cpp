// Programs of calls, in two worlds side by side. The first byte chooses what numbers there are, and the two worlds.

#include <array>

#include "program.h"
#include "target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace atl;
  if (size == 0) return 0;
  const std::uint8_t choice = data[0];
  const fuzz::Numbers numbers = (choice & 1) != 0 ? fuzz::Numbers::Any : fuzz::Numbers::Usual;
  const std::array<fuzz::Variant, 2> variants = {
      {{.threads = 1},
       {.threads = (choice & 2) != 0 ? 2 : 1, .simd = (choice & 4) != 0 ? Simd::Auto : Simd::Portable}}};
  fuzz::run_program({data + 1, size - 1}, numbers, variants);
  return 0;
}
