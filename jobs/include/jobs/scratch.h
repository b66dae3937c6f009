#pragma once

#include <jobs/arena.h>

#include <cstddef>
#include <exception>
#include <memory>
#include <utility>
#include <vector>

namespace atl::jobs {

/// One default-made T a worker, kept between steps so that a steady state allocates nothing. Which worker
/// runs a chunk is not fixed: what a loop leaves in one is for that chunk alone, or to be put in order after.
template <typename T>
class Scratch {
 public:
  explicit Scratch(int threads) { reach(threads); }
  /// Makes it do for so many workers, if it is for fewer.
  void reach(int threads) {
    while (items_.size() < static_cast<std::size_t>(threads)) items_.push_back(std::make_unique<T>());
  }

  /// The calling worker's, inside a loop of the arena. A loop that its caller runs alone may find itself in
  /// somebody else's arena, with any index: there is no second worker then to share with.
  T& local() {
    const std::size_t worker = worker_index();
    return *items_[worker < items_.size() ? worker : 0];
  }

  /// Calls visit(item) for all, outside any loop. Their contents depend on which thread did what: sort them.
  template <typename Visit>
  void for_each(const Visit& visit) {
    for (const std::unique_ptr<T>& item : items_) visit(*item);
  }
  template <typename Visit>
  void for_each(const Visit& visit) const {
    for (const std::unique_ptr<T>& item : items_) visit(std::as_const(*item));
  }

 private:
  std::vector<std::unique_ptr<T>> items_;
};

/// The calling thread's T, default-made when it first asks and kept until the thread ends, whatever world it works for:
/// many small worlds that take turns on a thread find it in cache. It is for what begins and ends within one call
/// that waits for no other task.
template <typename T>
T& of_this_thread() {
  thread_local T item;
  return item;
}

/// A T of this thread that nobody else uses, default-made if there is none, as long as this lives; the next one gets it
/// as this one leaves it, unless by an exception. It is for what lasts longer than of_this_thread() allows: while other
/// tasks run, or while functions of users are asked, which may step other worlds.
template <typename T>
class Borrowed {
 public:
  Borrowed() {
    if (idle().empty()) {
      item_ = std::make_unique<T>();
      idle().reserve(idle().capacity() + 1);  // so that it needs no memory as it is given back
    } else {
      item_ = std::move(idle().back());
      idle().pop_back();
    }
  }
  ~Borrowed() {
    if (std::uncaught_exceptions() == exceptions_) idle().push_back(std::move(item_));
  }
  Borrowed(const Borrowed&) = delete;
  Borrowed& operator=(const Borrowed&) = delete;

  T& operator*() const { return *item_; }
  T* operator->() const { return item_.get(); }

 private:
  static std::vector<std::unique_ptr<T>>& idle() { return of_this_thread<std::vector<std::unique_ptr<T>>>(); }

  std::unique_ptr<T> item_;
  const int exceptions_ = std::uncaught_exceptions();
};

}  // namespace atl::jobs
