#pragma once

#include <string>
#include <vector>

#include "record.h"

namespace atl::command {

/// A setting that a driver knows, by its options.
struct PeerSetting {
  std::string label;
  std::vector<std::string> options;
  bool large = false;  ///< worth running in large scenes
};

/// A run of a driver's: the scene as it is given to `atoll sweep`.
struct PeerRun {
  std::string scene;
  int steps = 0;
  double dt = 0;  ///< s
  std::uint64_t seed = 1;
};

/// Another engine, run through its driver program (see perf/README.md, "Drivers").
class PeerDriver {
 public:
  /// Asks the program what it is. A run is stopped after `limit` s. Throws Failure with Status::Usage, naming the
  /// option, unless it answers as a driver does.
  PeerDriver(std::string program, double limit);

  const std::string& engine() const { return engine_; }
  const std::string& version() const { return version_; }
  const std::string& precision() const { return precision_; }  ///< "single" or "double"
  const std::vector<PeerSetting>& settings() const { return settings_; }

  /// With nothing measured yet.
  Record describe(const PeerSetting& setting, const PeerRun& run) const;
  /// Fills in outcome and errors.
  void measure_errors(const PeerSetting& setting, const PeerRun& run, Record& record) const;
  /// Adds one sample of the time of at least `least_time` s of stepping, or changes the outcome.
  void measure_time(const PeerSetting& setting, const PeerRun& run, double least_time, Record& record) const;

 private:
  std::string call(const PeerSetting& setting, const PeerRun& run, const std::vector<std::string>& what,
                   Record& record) const;

  std::string program_;
  double limit_;
  std::string engine_;
  std::string version_;
  std::string precision_;
  std::vector<PeerSetting> settings_;
};

}  // namespace atl::command
