// Says of a call that is refused what is wrong with its arguments, in place of all signatures that there are.

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <unordered_map>
#include <utility>

#include "casters.h"
#include "parts.h"

namespace atl::python {
namespace {

// How nanobind calls functions: the few ways that there are, each kept at a place of its own.
std::array<vectorcallfunc, 8> ways{};

// Names of functions as users write them: "World.add_body".
std::unordered_map<PyObject*, std::string> names;

nb::list arguments_of(nb::handle function) {
  const nb::object find = nb::module_::import_("re").attr("findall");
  nb::list arguments;
  for (const nb::handle overload : function.attr("__nb_signature__")) {
    arguments.extend(find("[(,] ?(\\w+):", overload[0]));
  }
  return arguments;
}

// Names the first keyword that is no argument, and the one that may be meant. Empty if all keywords are arguments.
std::string words_of_misspelt(nb::handle function, nb::handle keywords) {
  const nb::list arguments = arguments_of(function);
  for (const nb::handle keyword : keywords) {
    if (nb::cast<bool>(arguments.attr("__contains__")(keyword))) continue;
    const nb::object close = nb::module_::import_("difflib").attr("get_close_matches")(keyword, arguments, 1);
    const bool meant = nb::len(close) > 0;
    const bool of_struct = nb::cast<std::string>(function.attr("__name__")) == "__init__";
    return (of_struct ? "no field '" : "no argument '") + nb::cast<std::string>(keyword) +
           (meant ? "'; did you mean '" : "'; expected of ") +
           nb::cast<std::string>(nb::str(", ").attr("join")(meant ? close : nb::object(arguments))) +
           (meant ? "'?" : "");
  }
  return {};
}

// Puts words that say more in place of nanobind's TypeError for arguments that fit no signature.
void explain(PyObject* function, PyObject* keywords) noexcept {
  nb::python_error raised;
  try {
    const std::string found = nb::str(raised.value()).c_str();
    std::string words;
    if (found.find("incompatible function arguments") != std::string::npos) {
      if (keywords != nullptr) words = words_of_misspelt(function, keywords);
      if (words.empty()) words = refusal();
    }
    if (words.empty()) {
      raised.restore();
    } else {
      PyErr_SetString(PyExc_TypeError, (names.at(function) + ": " + words).c_str());
    }
  } catch (...) {
    raised.restore();
  }
}

template <std::size_t way>
PyObject* call_and_explain(PyObject* function, PyObject* const* arguments, std::size_t count, PyObject* keywords) {
  std::string outer;  // of a call that this one is made within
  outer.swap(refusal());
  PyObject* result = ways[way](function, arguments, count, keywords);
  if (result == nullptr && PyErr_ExceptionMatches(PyExc_TypeError) != 0) explain(function, keywords);
  outer.swap(refusal());
  return result;
}

template <std::size_t... way>
constexpr std::array<vectorcallfunc, sizeof...(way)> calls_of(std::index_sequence<way...>) {
  return {&call_and_explain<way>...};
}

void watch(nb::handle function, const std::string& name) {
  if (!nb::hasattr(function, "__nb_signature__") || !names.emplace(function.ptr(), name).second) return;
  static constexpr auto calls = calls_of(std::make_index_sequence<ways.size()>());
  auto* place = reinterpret_cast<char*>(function.ptr()) + Py_TYPE(function.ptr())->tp_vectorcall_offset;
  auto& called = *reinterpret_cast<vectorcallfunc*>(place);
  const auto known = std::find_if(ways.begin(), ways.end(), [&](auto way) { return way == called || !way; });
  if (known == ways.end()) return;
  *known = called;
  called = calls[static_cast<std::size_t>(known - ways.begin())];
}

}  // namespace

void explain_arguments(nb::module_& module) {
  const nb::object items = nb::module_::import_("builtins").attr("vars");
  for (const nb::handle item : nb::list(items(module).attr("items")())) {
    const auto name = nb::cast<std::string>(item[0]);
    watch(item[1], name);
    if (!nb::isinstance<nb::type_object>(item[1])) continue;
    for (const nb::handle part : nb::list(items(item[1]).attr("items")())) {
      const auto of = nb::cast<std::string>(part[0]);
      watch(part[1], of == "__init__" ? name : name + "." + of);
      if (nb::hasattr(part[1], "fset")) watch(part[1].attr("fset"), name + "." + of);
    }
  }
}

}  // namespace atl::python
