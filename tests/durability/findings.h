// What a run of kills has found.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

namespace sightline::tests::durability {

/// Threads: any.
class Findings {
 public:
  /// Records that something is wrong.
  void add(std::uint64_t& count, const std::string& what) {
    const std::lock_guard lock(mutex_);
    ++count;
    if (examples_.size() < kExamples) examples_.push_back(what);
  }
  const std::vector<std::string>& examples() const { return examples_; }
  bool clean() const { return lost + halves + gaps + repeats + missing + wrong + other == 0; }

  std::uint64_t lost = 0;     ///< Acknowledged writes that are gone.
  std::uint64_t halves = 0;   ///< Revisions that hold a part of a batch.
  std::uint64_t gaps = 0;     ///< Revisions or batches left out.
  std::uint64_t repeats = 0;  ///< Batches or requests applied twice.
  std::uint64_t missing = 0;  ///< Acknowledged uploads that are gone.
  std::uint64_t wrong = 0;    ///< Rays with another answer than brute force.
  std::uint64_t other = 0;    ///< Calls that failed for another reason than the kill.

 private:
  static constexpr std::size_t kExamples = 20;
  std::mutex mutex_;
  std::vector<std::string> examples_;
};

}  // namespace sightline::tests::durability
