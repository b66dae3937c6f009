#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace atl {

struct WorldDefinition;

/// The state of a world at one moment: see World::save() and World::restore(). A value, of about 150 bytes a body that
/// is awake and 200 a pair that touches in four points; what never changes of bodies, geometry above all, is shared
/// with the world and other snapshots. Independent snapshots may be used from different threads.
class Snapshot {
 public:
  Snapshot() = default;  ///< empty

  bool empty() const { return size_ == 0; }
  std::size_t size() const { return size_; }  ///< bytes of state

  /// To a file, by way of a temporary one beside it: there is all of it or what was there before. Hulls, meshes and
  /// height fields are written as fingerprints only, all else of shapes in full. Throws Error if the snapshot is empty
  /// or the file can't be written.
  void write(const std::string& path) const;
  /// Throws Error, saying what was found and expected, if the file can't be read, is not a snapshot, is damaged or cut
  /// off, or is of another version or byte order.
  static Snapshot read(const std::string& path);

  /// The bytes that write() would put into a file, and the snapshot that read() would make of them.
  std::vector<std::byte> to_bytes() const;
  static Snapshot from_bytes(std::span<const std::byte> bytes);

 private:
  friend class World;
  friend class Batch;

  static Snapshot from_bytes(std::span<const std::byte> bytes, const std::string& place);

  std::span<const std::byte> state() const {
    return empty() ? std::span<const std::byte>() : std::span(bytes_->data(), size_);
  }
  bool owns_bytes() const;  // alone, so that it may write them
  /// Has its state in another's memory, if that is the same; else in as little as it takes.
  void fit(const Snapshot& other);

  std::shared_ptr<std::vector<std::byte>> bytes_;  // shared by copies; never smaller than it was
  std::size_t size_ = 0;                           // of those in use
  std::shared_ptr<const WorldDefinition> world_definition_;
  std::uint64_t origin_ = 0;  // the world's serial number; 0 from a file
};

}  // namespace atl
