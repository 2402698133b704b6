// Buckets: 2^kPrecisionBits for each power of two.
#include "client/load/histogram.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>

namespace sightline::client::load {
namespace {

// How many low bits of a value its bucket does not tell.
int shift_of(std::uint64_t value) {
  return std::max(static_cast<int>(std::bit_width(value)) - (Histogram::kPrecisionBits + 1), 0);
}

std::size_t bucket_of(std::uint64_t value) {
  const int shift = shift_of(value);
  return (static_cast<std::size_t>(shift) << Histogram::kPrecisionBits) + (value >> shift);
}

// The middle of a bucket.
std::uint64_t value_of(std::size_t bucket) {
  constexpr std::size_t kExact = std::size_t{2} << Histogram::kPrecisionBits;
  if (bucket < kExact) return bucket;
  const std::size_t shift = (bucket >> Histogram::kPrecisionBits) - 1;
  const std::uint64_t low = (bucket - (shift << Histogram::kPrecisionBits)) << shift;
  return low + ((std::uint64_t{1} << shift) - 1) / 2;
}

}  // namespace

void Histogram::add(std::uint64_t value) {
  const std::size_t bucket = bucket_of(value);
  if (bucket >= counts_.size()) counts_.resize(bucket + 1);
  ++counts_[bucket];
  ++count_;
  max_ = std::max(max_, value);
  sum_ += static_cast<double>(value);
}

void Histogram::add(const Histogram& other) {
  if (other.counts_.size() > counts_.size()) counts_.resize(other.counts_.size());
  for (std::size_t i = 0; i < other.counts_.size(); ++i) counts_[i] += other.counts_[i];
  count_ += other.count_;
  max_ = std::max(max_, other.max_);
  sum_ += other.sum_;
}

double Histogram::mean() const { return count_ == 0 ? 0 : sum_ / static_cast<double>(count_); }

std::uint64_t Histogram::quantile(double share) const {
  if (count_ == 0) return 0;
  const double wanted = std::ceil(std::clamp(share, 0.0, 1.0) * static_cast<double>(count_));
  const auto rank = std::clamp<std::uint64_t>(static_cast<std::uint64_t>(wanted), 1, count_);
  std::uint64_t below = 0;
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    below += counts_[i];
    if (below >= rank) return std::min(value_of(i), max_);
  }
  return max_;
}

}  // namespace sightline::client::load
