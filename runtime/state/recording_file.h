#pragma once
/// Recordings as files: a header, then records one after another, each with a checksum of its own, and at the end one
/// with their number and a checksum of all of these. What is inside a record is recorder.h's.

#include <jobs/hash.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <vector>

#include "state/files.h"

namespace atl {

/// The version is of all that follows, the state as in snapshot.cpp included.
inline constexpr FileHeader recording_header = {.magic = {'A', 'T', 'O', 'L', 'L', 'R', 'E', 'C'}, .version = 23};

enum class RecordKind : std::uint32_t {
  Begin = 1,  ///< whose recording it is
  Geometry,   ///< a hull, mesh or height field, ahead of the first that has it
  BodyKind,   ///< what never changes of bodies, numbered from 0 in the order in which they come
  AddBody,
  State,   ///< to take on: all of a world as the recording began, or as it was restored
  Step,    ///< to do: dt, and whether a force law, a contact filter and a contact modifier have a say in it
  Hash,    ///< of the state after a step, or as the recording began
  Bodies,  ///< hashes of them, one by one
  End,
  Forces,          ///< what a force law asked for
  SetShape,        ///< of a body, as one of the kinds
  ContactAnswers,  ///< what a contact filter or modifier said in a step, at one of the times when they were asked
  Call = 256,      ///< the first of those in RecordedCall (recorded_calls.h)
};

struct RecordHeader {
  RecordKind kind = RecordKind::End;
  std::uint32_t check = 0;     // of the rest of this
  std::uint64_t length = 0;    // bytes that follow
  std::uint64_t checksum = 0;  // of these
};
static_assert(sizeof(RecordHeader) == 24);

/// The header of a record with that in it.
RecordHeader record_header(RecordKind kind, std::span<const std::byte> content);

/// Contents of the last record.
struct RecordingEnd {
  std::uint64_t records = 0;   // before it
  std::uint64_t checksum = 0;  // of all their headers' checks, in order
};
static_assert(sizeof(RecordingEnd) == 16);

/// Counts records as they are written or read.
class RecordingTally {
 public:
  void count(const RecordHeader& header) {
    ++records_;
    hash_.add(std::uint64_t{header.check});
  }
  RecordingEnd end() const { return {records_, hash_.value()}; }

 private:
  std::uint64_t records_ = 0;
  jobs::Hash hash_;
};

/// Writes to a file beside the one that is asked for, which has ".partial" after its name and gets the right one at the
/// end: what is left of a program that crashes doesn't replace anything.
class RecordingWriter {
 public:
  /// Throws Error, naming `call`, if the file can't be written.
  RecordingWriter(const char* call, const std::filesystem::path& path);

  /// Errors of writing are reported by finish().
  void write(RecordKind kind, std::span<const std::byte> content);
  void flush();
  /// Throws Error, naming `call`, if the file could not be written; it is removed then.
  void finish(const char* call);

 private:
  void record_error();

  std::filesystem::path path_;
  std::filesystem::path partial_;
  std::ofstream stream_;
  RecordingTally tally_;
  int error_ = 0;  // the first one's number
};

/// Reads a file, record by record. Throws Error that says what was found, where, and what was expected.
class RecordingReader {
 public:
  /// Goes over all of the file, to see that it is whole.
  explicit RecordingReader(const std::filesystem::path& path);

  /// The next record; nothing after the last whole one, which in a file that is complete is the one before its end.
  bool next();
  RecordKind kind() const { return header_.kind; }
  std::span<const std::byte> content() const { return content_; }
  std::string place() const;  ///< of the record: "record 3 at byte 1234"

  std::int64_t steps() const { return steps_; }  ///< in all of it
  bool complete() const { return complete_; }    ///< not cut off

  /// The place of a record that can be read next.
  struct Place {
    std::uint64_t at = 0;      // in the file
    std::uint64_t number = 0;  // of records before
  };
  Place before() const { return {begin_, number_ - 1}; }  ///< of the one that was read last
  Place after() const { return {at_, number_}; }
  void go_to(const Place& place);

  [[noreturn]] void fail(const std::string& why) const;

 private:
  void check_header();
  void scan();
  bool read_record();  // false at the end, or where the file is cut off
  bool take(void* data, std::uint64_t count);

  std::filesystem::path path_;
  std::ifstream stream_;
  std::uint64_t size_ = 0;   // of the file
  std::uint64_t at_ = 0;     // in the file
  std::uint64_t begin_ = 0;  // of the record
  std::uint64_t number_ = 0;
  RecordHeader header_;
  std::vector<std::byte> content_;
  std::int64_t steps_ = 0;
  bool complete_ = false;
};

}  // namespace atl
