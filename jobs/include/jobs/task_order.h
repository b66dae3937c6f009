#pragma once
/// Tells the thread sanitizer what it cannot see: oneTBB's library is not instrumented, so to the sanitizer a
/// task's hand-over orders nothing. Nothing in other builds.

#if defined(__SANITIZE_THREAD__)
#define ATL_THREAD_SANITIZER
#elif defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define ATL_THREAD_SANITIZER
#endif
#endif

#ifdef ATL_THREAD_SANITIZER
#include <sanitizer/tsan_interface.h>
#endif

namespace atl::jobs {

#ifdef ATL_THREAD_SANITIZER
inline char fork_order, join_order;  // of all arenas, since a task must not read anything before it begins
inline void before_tasks() { __tsan_release(&fork_order); }
inline void task_begins() { __tsan_acquire(&fork_order); }
inline void task_ends() { __tsan_release(&join_order); }
inline void after_tasks() { __tsan_acquire(&join_order); }
#else
inline void before_tasks() {}
inline void task_begins() {}
inline void task_ends() {}
inline void after_tasks() {}
#endif

}  // namespace atl::jobs
