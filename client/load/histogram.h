// Counts durations in buckets of a fixed relative width, as HDR histograms do.
#pragma once

#include <cstdint>
#include <vector>

namespace sightline::client::load {

/// Values are exact below 2^(kPrecisionBits + 1), and known to within a share of
/// 2^-(kPrecisionBits + 1) of themselves above.
/// Threads: one at a time.
class Histogram {
 public:
  static constexpr int kPrecisionBits = 8;

  void add(std::uint64_t value);
  void add(const Histogram& other);

  std::uint64_t count() const { return count_; }
  std::uint64_t max() const { return max_; }  ///< exact; 0 if empty
  double mean() const;                        ///< exact; 0 if empty
  /// The smallest value that at least this share (0 to 1) of all values do not exceed. 0 if empty.
  std::uint64_t quantile(double share) const;

 private:
  std::vector<std::uint64_t> counts_;  // by bucket
  std::uint64_t count_ = 0;
  std::uint64_t max_ = 0;
  double sum_ = 0;
};

}  // namespace sightline::client::load
