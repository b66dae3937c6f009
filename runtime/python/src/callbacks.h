#pragma once
/// Functions of Python that a step asks.

#include <atoll/error.h>
#include <nanobind/nanobind.h>

#include <functional>
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

/// A function of Python as one of C++, which lends what it is asked of.
template <typename Answer, typename Question>
std::function<Answer(Question&)> function_of(nb::object callable) {
  if (callable.is_none()) return {};
  // It is dropped on whichever thread ends its use.
  const std::shared_ptr<nb::object> kept(new nb::object(std::move(callable)), [](nb::object* function) {
    const nb::gil_scoped_acquire lock;
    delete function;
  });
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
