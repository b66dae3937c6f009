#include "file_size.h"

#include <algorithm>
#include <string_view>

namespace atl::scene {
namespace {

const JsonValue* member(const JsonValue& value, std::string_view key) {
  const auto* object = std::get_if<JsonValue::Object>(&value.data);
  if (object == nullptr) return nullptr;
  for (const JsonValue::Member& each : *object) {
    if (each.key == key) return &each.value;
  }
  return nullptr;
}

double length(const JsonValue* array) {
  const auto* values = array == nullptr ? nullptr : std::get_if<JsonValue::Array>(&array->data);
  return values == nullptr ? 0 : static_cast<double>(values->size());
}

double number(const JsonValue& value) {
  const double* found = std::get_if<double>(&value.data);
  return found == nullptr ? 1 : std::max(*found, 1.0);
}

// Bodies of a lattice "count": [x, y, layers]; a taper takes as much off each layer above.
double lattice_size(const JsonValue& lattice) {
  const JsonValue* count = member(lattice, "count");
  const auto* along = count == nullptr ? nullptr : std::get_if<JsonValue::Array>(&count->data);
  if (along == nullptr || along->size() != 3) return 1;
  const double x = number((*along)[0]), y = number((*along)[1]), layers = number((*along)[2]);
  const JsonValue* taper = member(lattice, "taper");
  const auto* less = taper == nullptr ? nullptr : std::get_if<JsonValue::Array>(&taper->data);
  if (less == nullptr || less->size() != 2) return x * y * layers;
  const auto less_along = [&](std::size_t i) {
    const double* found = std::get_if<double>(&(*less)[i].data);
    return found == nullptr ? 0 : std::max(*found, 0.0);
  };
  // The sum of (x - a i) (y - b i) over layers i.
  const double a = less_along(0), b = less_along(1), n = layers - 1;
  return layers * x * y - (a * y + b * x) * n * layers / 2 + a * b * n * layers * (2 * n + 1) / 6;
}

void add_shapes(const JsonValue& value, SceneSize& size) {
  if (const auto* array = std::get_if<JsonValue::Array>(&value.data)) {
    for (const JsonValue& each : *array) add_shapes(each, size);
  }
  const auto* object = std::get_if<JsonValue::Object>(&value.data);
  if (object == nullptr) return;
  size.hull_vertices += length(member(value, "points"));
  size.triangles += length(member(value, "triangles"));
  for (const JsonValue::Member& each : *object) {
    if (each.key != "points" && each.key != "triangles" && each.key != "vertices") add_shapes(each.value, size);
  }
}

}  // namespace

SceneSize size_of_file(const JsonValue& root) {
  SceneSize size = {.bodies = length(member(root, "bodies")), .joints = length(member(root, "joints"))};
  add_shapes(root, size);
  const JsonValue* generators = member(root, "generators");
  const auto* each = generators == nullptr ? nullptr : std::get_if<JsonValue::Array>(&generators->data);
  if (each == nullptr) return size;
  for (const JsonValue& generator : *each) {
    const JsonValue* copies = member(generator, "copies");
    size.bodies += lattice_size(generator) * (copies == nullptr ? 1 : lattice_size(*copies));
  }
  return size;
}

}  // namespace atl::scene
