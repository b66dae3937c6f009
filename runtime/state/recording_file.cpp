#include "state/recording_file.h"

#include <atoll/error.h>
#include <atoll/recording.h>

#include <cerrno>
#include <cstring>
#include <system_error>

#include "state/files.h"
#include "state/hex.h"

namespace atl {
namespace {

namespace fs = std::filesystem;

std::uint32_t check_of(const RecordHeader& header) {
  jobs::Hash hash;
  hash.add(std::uint64_t{static_cast<std::uint32_t>(header.kind)});
  hash.add(header.length);
  hash.add(header.checksum);
  return static_cast<std::uint32_t>(hash.value());
}

[[noreturn]] void fail_writing(const char* call, const fs::path& path, const std::string& why) {
  throw Error(std::string(call) + ": " + path.string() + ": " + why);
}

std::string words_of(int error) { return std::generic_category().message(error != 0 ? error : EIO); }

}  // namespace

RecordHeader record_header(RecordKind kind, std::span<const std::byte> content) {
  RecordHeader header{.kind = kind, .length = content.size(), .checksum = checksum_of(content)};
  header.check = check_of(header);
  return header;
}

RecordingWriter::RecordingWriter(const char* call, const fs::path& path) : path_(path), partial_(path) {
  partial_ += ".partial";
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!path.has_filename() || fs::is_directory(status)) {
    fail_writing(call, path, "is a directory; expected the name of a file");
  }
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    fail_writing(call, path, "is there and is no regular file; expected one or none");
  }
  errno = 0;
  stream_.open(partial_, std::ios::binary | std::ios::trunc);
  if (!stream_) fail_writing(call, partial_, words_of(errno));
  stream_.write(reinterpret_cast<const char*>(&recording_header), sizeof recording_header);
}

void RecordingWriter::write(RecordKind kind, std::span<const std::byte> content) {
  const RecordHeader header = record_header(kind, content);
  tally_.count(header);
  stream_.write(reinterpret_cast<const char*>(&header), sizeof header);
  stream_.write(reinterpret_cast<const char*>(content.data()), static_cast<std::streamsize>(content.size()));
  record_error();
}

void RecordingWriter::flush() {
  stream_.flush();
  record_error();
}

void RecordingWriter::record_error() {
  if (!stream_ && error_ == 0) error_ = errno != 0 ? errno : EIO;
}

void RecordingWriter::finish(const char* call) {
  const RecordingEnd end = tally_.end();
  write(RecordKind::End, std::as_bytes(std::span(&end, 1)));
  stream_.close();
  record_error();
  std::error_code error;
  if (error_ == 0) fs::rename(partial_, path_, error);
  if (error_ == 0 && !error) return;
  std::error_code ignored;
  fs::remove(partial_, ignored);
  fail_writing(call, path_, error_ != 0 ? words_of(error_) : error.message());
}

bool is_recording(const std::string& path) {
  if (!irregular_kind(path).empty()) return false;
  std::ifstream file(path, std::ios::binary);
  decltype(FileHeader::magic) begin = {};
  return file.read(begin.data(), begin.size()) && begin == recording_header.magic;
}

RecordingReader::RecordingReader(const fs::path& path) : path_(path) {
  if (const std::string kind = irregular_kind(path); !kind.empty())
    fail("is " + kind + "; expected a recording's file");
  errno = 0;
  stream_.open(path, std::ios::binary);
  if (!stream_) fail(words_of(errno));
  std::error_code error;
  size_ = fs::file_size(path, error);
  if (error) fail(error.message());
  check_header();
  scan();
}

void RecordingReader::fail(const std::string& why) const { throw Error("replay: " + path_.string() + ": " + why); }

std::string RecordingReader::place() const {
  return "record " + std::to_string(number_) + " at byte " + std::to_string(begin_);
}

bool RecordingReader::take(void* data, std::uint64_t count) {
  if (size_ - at_ < count) return false;
  errno = 0;
  stream_.read(static_cast<char*>(data), static_cast<std::streamsize>(count));
  if (!stream_) fail(words_of(errno));
  at_ += count;
  return true;
}

void RecordingReader::check_header() {
  FileHeader header;
  const bool is_long_enough = take(&header.magic, sizeof header.magic);
  if (!is_long_enough || header.magic != recording_header.magic) {
    fail("does not begin with \"ATOLLREC\"; expected a recording's file");
  }
  if (!take(&header.order, sizeof header.order) || !take(&header.version, sizeof header.version)) {
    fail("found " + std::to_string(size_) + " bytes; expected a header of " + std::to_string(sizeof header) +
         " at least");
  }
  if (const std::string fault = fault_of(header, recording_header); !fault.empty()) fail(fault);
}

bool RecordingReader::read_record() {
  begin_ = at_;
  ++number_;
  if (!take(&header_, sizeof header_)) return false;
  if (header_.check != check_of(header_)) {
    fail(place() + ": found the check " + hex(header_.check) + " in its header; expected " + hex(check_of(header_)) +
         ": the file is damaged");
  }
  if (size_ - at_ < header_.length) return false;
  content_.resize(header_.length);
  take(content_.data(), header_.length);
  if (const std::uint64_t checksum = checksum_of(content_); checksum != header_.checksum) {
    fail(place() + ": found the checksum " + hex(checksum) + "; expected " + hex(header_.checksum) +
         ": the file is damaged");
  }
  return true;
}

void RecordingReader::scan() {
  RecordingTally tally;
  while (read_record()) {
    if (header_.kind == RecordKind::End) {
      const RecordingEnd expected = tally.end();
      RecordingEnd end;
      if (content_.size() != sizeof end) fail(place() + ": found an end of a wrong size");
      std::memcpy(&end, content_.data(), sizeof end);
      if (end.records != expected.records || end.checksum != expected.checksum) {
        fail(place() + ": found an end to " + std::to_string(end.records) + " records with the checksum " +
             hex(end.checksum) + "; expected one to " + std::to_string(expected.records) + " with " +
             hex(expected.checksum) + ": the file is damaged");
      }
      if (at_ != size_) fail("found " + std::to_string(size_ - at_) + " bytes after the end; expected none");
      complete_ = true;
      break;
    }
    tally.count(header_);
    if (header_.kind == RecordKind::Step) ++steps_;
  }
  go_to({.at = sizeof recording_header, .number = 0});
}

void RecordingReader::go_to(const Place& place) {
  stream_.clear();
  stream_.seekg(static_cast<std::streamoff>(place.at));
  at_ = place.at;
  number_ = place.number;
}

bool RecordingReader::next() { return read_record() && header_.kind != RecordKind::End; }

}  // namespace atl
