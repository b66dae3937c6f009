#pragma once
/// Parts of calls on many worlds: the choice of worlds, and arrays over them.

#include <atoll/batch.h>
#include <atoll/error.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "arrays.h"

namespace atl::python {

using Values = ArrayLike<double>;
template <int columns>
using Cube = ArrayLike<double, nb::shape<-1, -1, columns>>;

using Mask = nb::ndarray<const bool, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Places = nb::ndarray<const std::int64_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

#define ATOLL_WORLDS \
  "numpy.typing.NDArray[numpy.bool_] | numpy.typing.NDArray[numpy.int64] | collections.abc.Sequence[int] | None"

/// Which worlds are meant: those that a mask has, or that are listed. None: all.
struct Chosen {
  std::vector<std::size_t> places;
  bool any = true;

  Chosen(const Batch& batch, const nb::object& worlds) {
    if (worlds.is_none()) return;
    Mask mask;
    if (nb::try_cast(worlds, mask, false)) {
      if (mask.shape(0) != batch.size()) {
        throw Error("Batch: found a mask of " + std::to_string(mask.shape(0)) + "; expected one of " +
                    std::to_string(batch.size()) + ", a bool a world");
      }
      for (std::size_t i = 0; i < mask.shape(0); ++i) {
        if (mask.data()[i]) places.push_back(i);
      }
    } else {
      const nb::object listed = nb::module_::import_("numpy").attr("asarray")(worlds, "int64");
      const Places numbers = nb::cast<Places>(listed);
      for (std::size_t i = 0; i < numbers.shape(0); ++i) {
        const std::int64_t place = numbers.data()[i];
        if (place < 0) throw Error("Batch: found place " + std::to_string(place) + "; expected 0 or more");
        places.push_back(static_cast<std::size_t>(place));
      }
    }
    any = !places.empty();
  }
};

/// Calls `make` of the worlds that are meant, without Python's lock.
template <typename Make>
void call(Batch& batch, const nb::object& worlds, const Make& make) {
  const Chosen chosen(batch, worlds);
  if (!chosen.any) return;
  const nb::gil_scoped_release release;
  make(std::span<const std::size_t>(chosen.places));
}

template <typename Array>
std::span<const double> span_of(const Array& array) {
  return {array.data(), array.size()};
}

inline nb::object array_owning(std::vector<double> numbers, const std::vector<std::size_t>& shape) {
  auto* kept = new std::vector<double>(std::move(numbers));
  const nb::capsule owner(kept, [](void* memory) noexcept { delete static_cast<std::vector<double>*>(memory); });
  return nb::ndarray<nb::numpy, double>(kept->data(), shape.size(), shape.data(), owner).cast();
}

/// The column of an array, by its name; Error, which begins as told, if there is none.
Batch::Column column_named(const char* call, const std::string& name);

void bind_batch_arrays(nb::class_<Batch>& batch);
void bind_batch_changes(nb::module_& module, nb::class_<Batch>& batch);

}  // namespace atl::python
