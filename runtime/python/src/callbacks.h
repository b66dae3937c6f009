#pragma once
/// Functions of Python that a step asks.

#include <atoll/error.h>
#include <atoll/world.h>
#include <nanobind/nanobind.h>

#include <functional>
#include <iterator>
#include <map>
#include <memory>
#include <type_traits>
#include <utility>

namespace atl::python {

namespace nb = nanobind;

/// numpy's bools too.
inline bool is_true(nb::handle value) { return nb::cast<bool>(nb::bool_(value)); }

/// An object that is lent to a Python function until the function returns.
template <typename T>
struct Lent {
  T* lent = nullptr;

  T& get() const {
    if (lent == nullptr) {
      throw Error("What a function was asked of is gone once it has answered; expected to be used within the function");
    }
    return *lent;
  }
};

/// Functions of Python that worlds hold, by the world. Under Python's lock.
inline std::multimap<const World*, const nb::object*>& held_functions() {
  static std::multimap<const World*, const nb::object*> held;
  return held;
}

/// Slots by which Python's collector goes through worlds and batches, so that it can end rings of them and of their
/// functions.
extern PyType_Slot world_slots[3];
extern PyType_Slot batch_slots[3];

/// A function of Python as one of C++, which lends what it is asked of. A world that keeps it is its holder.
template <typename Answer, typename Question>
std::function<Answer(Question&)> function_of(nb::object callable, const World* holder = nullptr) {
  if (callable.is_none()) return {};
  // It is dropped on whichever thread ends its use.
  const std::shared_ptr<nb::object> kept(new nb::object(std::move(callable)), [holder](nb::object* function) {
    const nb::gil_scoped_acquire lock;
    auto [held, last] = held_functions().equal_range(holder);
    while (held != last) held = held->second == function ? held_functions().erase(held) : std::next(held);
    delete function;
  });
  if (holder != nullptr) held_functions().emplace(holder, kept.get());
  return [kept](Question& of) -> Answer {
    const nb::gil_scoped_acquire lock;
    struct Loan {
      nb::object question;
      ~Loan() { nb::cast<Lent<Question>&>(question).lent = nullptr; }
    } const loan{nb::cast(Lent<Question>{&of})};
    const nb::object answer = (*kept)(loan.question);
    if constexpr (!std::is_void_v<Answer>) return is_true(answer);
  };
}

}  // namespace atl::python
