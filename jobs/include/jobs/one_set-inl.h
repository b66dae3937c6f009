// Restricts a file to one instruction set, ATOLL_SET (of Highway's HWY_AVX3, HWY_AVX2, ...), which the build gives it: a
// file of kernels is compiled once for each, side by side. Included ahead of <hwy/foreach_target.h>. Highway always wants
// a set that every machine has: where ATOLL_SET isn't one, it goes over the portable set, too, and last, so what isn't for
// ATOLL_SET stands behind `#if HWY_TARGET == ATOLL_SET`.

#include <hwy/detect_targets.h>
#undef HWY_DISABLED_TARGETS
#if HWY_BASELINE_TARGETS & ATOLL_SET
#define HWY_DISABLED_TARGETS (~ATOLL_SET)
#else
#define HWY_DISABLED_TARGETS (~(ATOLL_SET | HWY_BASELINE_SCALAR))
#endif
