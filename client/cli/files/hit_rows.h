// The rows of a hit file, from a cast of all hits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "client/cast_options.h"
#include "client/cli/files/hit_columns.h"

namespace sightline::client::cli::files {

/// Makes the rows of a file from a cast of all hits: one row per hit. A bad ray gets one row with t
/// = NaN and node 0, so that a file tells it from a miss, which has no row; a ray without an answer
/// gets one with t = -inf. `hit` and `work` of a
/// ray are repeated in each of its rows. The memory is reused for the next answers.
class HitRows {
 public:
  /// `hits` answers rays from number `first` on, and has offsets and `hit`. The returned view is
  /// valid until the next call.
  RowView make(std::uint64_t first, const HitView& hits);
  std::size_t size() const { return ray_.size(); }

 private:
  void add_without_hit(double t);
  void add_hits(const HitView& hits, std::size_t i);

  std::vector<std::uint64_t> ray_, node_;
  std::vector<double> t_;
  std::vector<std::uint32_t> primitive_, work_, name_;
  std::vector<double> position_;
  std::vector<float> barycentric_, normal_;
  std::vector<std::uint8_t> hit_;
};

}  // namespace sightline::client::cli::files
