// All hits of rays as rows of a file.
#pragma once

#include <cstdint>
#include <vector>

#include "client/cli/files/hit_columns.h"
#include "client/rays.h"

namespace sightline::client::cli::files {

/// A row a hit, and for a bad ray one row with t = NaN and node 0, so that a file tells it from a
/// miss, which has none. `hit` and `work` are those of the ray, in each of its rows. The memory is
/// used again by the next answers.
class HitRows {
 public:
  /// `hits` answers rays from number `first` on, and has offsets and `hit`. What is returned lives
  /// until the next call.
  RowView make(std::uint64_t first, const HitView& hits);
  std::size_t size() const { return ray_.size(); }

 private:
  void add_bad_ray();
  void add_hits(const HitView& hits, std::size_t i);

  std::vector<std::uint64_t> ray_, node_;
  std::vector<double> t_;
  std::vector<std::uint32_t> primitive_, work_;
  std::vector<float> barycentric_, normal_;
  std::vector<std::uint8_t> hit_;
};

}  // namespace sightline::client::cli::files
