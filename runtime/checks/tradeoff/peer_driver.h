#pragma once

#include <atoll/error.h>

#include <string>
#include <vector>

#include "record.h"
#include "stop.h"

namespace atl::tradeoff {

/// A setting that a driver knows, by its options.
struct PeerSetting {
  std::string label;
  std::vector<std::string> options;
  bool large = false;  ///< worth running in large scenes
};

/// Thrown where a program can't be started, or doesn't answer as a driver does.
class DriverError : public Error {
 public:
  using Error::Error;
};

/// A run of a driver's: the scene as load_scene() takes it.
struct PeerRun {
  std::string scene;
  int steps = 0;
  double dt = 0;  ///< s
  std::uint64_t seed = 1;
};

/// Another engine, run through its driver program (see perf/peers/README.md, "Drivers").
class PeerDriver {
 public:
  /// Asks the program what it is. A run is ended after `limit` s. Throws DriverError. All throw Stopped.
  PeerDriver(std::string program, double limit, Stop stop = {});

  const std::string& engine() const { return engine_; }
  const std::string& version() const { return version_; }
  const std::string& precision() const { return precision_; }  ///< "single" or "double"
  const std::vector<PeerSetting>& settings() const { return settings_; }

  /// With nothing measured yet.
  Record describe(const PeerSetting& setting, const PeerRun& run) const;
  /// Fills in outcome and errors.
  void measure_errors(const PeerSetting& setting, const PeerRun& run, Record& record) const;
  /// Adds one sample of the time of at least `min_time` s of stepping, or changes the outcome.
  void measure_time(const PeerSetting& setting, const PeerRun& run, double min_time, Record& record) const;

 private:
  std::string call(const PeerSetting& setting, const PeerRun& run, const std::vector<std::string>& what,
                   Record& record) const;

  std::string program_;
  double limit_;
  Stop stop_;
  std::string engine_;
  std::string version_;
  std::string precision_;
  std::vector<PeerSetting> settings_;
};

/// One of each of these programs. Throws DriverError on two of the same engine, too.
std::vector<PeerDriver> ask_drivers(const std::vector<std::string>& programs, double limit, const Stop& stop);

}  // namespace atl::tradeoff
