// Convex hulls as bytes: a header, then the hull as it is in archives.

#include <atoll/error.h>
#include <atoll/shapes.h>
#include <features/with_hulls.h>

#include <string>

#include "state/files.h"
#include "state/geometry_state.h"
#include "state/state_archive.h"
#include "world/left_out.h"

namespace atl {
namespace {

constexpr FileHeader hull_header = {.magic = {'A', 'T', 'O', 'L', 'L', 'H', 'U', 'L'}, .version = 1};

template <typename Archive, typename Header>
void visit_header(Archive& archive, Header& header) {
  visit_all(archive, header.magic, header.order, header.version);
}

}  // namespace

std::vector<std::byte> ConvexHull::to_bytes() const {
  std::vector<std::byte> bytes;
  StateWriter writer(bytes);
  visit_header(writer, hull_header);
  visit_hull(writer, *hull_);
  bytes.resize(writer.size());
  return bytes;
}

ConvexHull ConvexHull::from_bytes(std::span<const std::byte> bytes) {
  if constexpr (!with_hulls) throw_left_out("ConvexHull::from_bytes is called", "hulls", "HULLS");
  const StateSource source = {
      .prefix = "ConvexHull::from_bytes: ", .what = "hull", .writer = "ConvexHull::to_bytes", .from_file = true};
  StateReader reader(bytes, source);
  FileHeader header;
  visit_header(reader, header);
  reader.check(header.magic == hull_header.magic, "no hull's header");
  if (const std::string fault = fault_of(header, hull_header); !fault.empty()) throw Error(source.prefix + fault);
  std::shared_ptr<const collision::Hull> hull = read_hull(reader);
  reader.check(reader.left() == 0, "more than there should be");
  return ConvexHull(std::move(hull));
}

}  // namespace atl
