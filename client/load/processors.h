// How much of this machine's processors the load test takes, and whether that spoils the
// measurement.
#pragma once

#include <string>

#include "client/load/clock.h"

namespace sightline::client::load {

/// The use between two moments. Times are summed over processors.
struct ProcessorUse {
  double elapsed_s = 0;
  int processors = 1;  ///< the machine's
  double own_s = 0;    ///< this process's, in the kernel too
  double busy_s = 0;   ///< all processes'; 0: unknown

  double own_share() const { return share(own_s); }    ///< share of the whole machine, 0 to 1
  double busy_share() const { return share(busy_s); }  ///< share of the whole machine, 0 to 1

 private:
  double share(double seconds) const {
    return elapsed_s > 0 ? seconds / (elapsed_s * processors) : 0;
  }
};

/// Measures from its construction on.
class ProcessorMeter {
 public:
  ProcessorMeter();
  ProcessorUse use() const;

 private:
  double begin_s_;
  double own_s_;
  double busy_s_;
};

/// A share of the machine from which the load test is suspected: kBusyOwnShare if the machine has
/// no time left, else kOwnShare. `in_flight_s` is the time that requests took, summed: the test's
/// own work must be at most kFlightShare of it, unless it keeps one processor busy for less than
/// kLeastOwn of the time.
inline constexpr double kOwnShare = 0.5;
inline constexpr double kBusyOwnShare = 0.25;
inline constexpr double kBusyShare = 0.95;
inline constexpr double kFlightShare = 0.5;
inline constexpr double kLeastOwn = 0.25;

/// A sentence that says why the load test itself is the bottleneck, or nothing if it is not.
std::string bottleneck(const ProcessorUse& use, double in_flight_s);

}  // namespace sightline::client::load
