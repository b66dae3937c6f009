#include <jobs/assert.h>

#include <cstdio>
#include <cstdlib>

namespace atl::jobs {

void assertion_failed(const char* file, int line, const char* condition, const char* names,
                      std::initializer_list<AssertedValue> values) {
  std::fprintf(stderr, "%s:%d: atoll asserts %s", file, line, condition);
  if (values.size() != 0) {
    std::fprintf(stderr, "; [%s] = [", names);
    const char* separator = "";
    for (const AssertedValue& asserted : values) {
      std::fprintf(stderr, "%s%.17g", separator, asserted.value);
      separator = ", ";
    }
    std::fputs("]", stderr);
  }
  std::fputs("\n", stderr);
  std::abort();
}

}  // namespace atl::jobs
