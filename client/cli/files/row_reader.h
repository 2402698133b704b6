// Rays or points that come one by one, from a file or from a program that may pause.
#pragma once

#include <chrono>
#include <functional>
#include <memory>

#include "client/cast_options.h"
#include "client/cli/files/input.h"
#include "client/cli/files/row_layout.h"
#include "client/result.h"

namespace sightline::client::cli::files {

class RowReader {
 public:
  virtual ~RowReader() = default;

  /// Reads the next ray. Returns false at the end. Errors: kInvalidArgument, naming the file and
  /// the place; kCancelled.
  virtual Result<bool> next(RayRow& row) = 0;
  /// Whether next() would not wait.
  virtual Result<bool> ready() = 0;
  /// Waits until ready(). Returns false if that takes longer.
  virtual Result<bool> wait(std::chrono::milliseconds longest) = 0;
};

/// RowReader::wait() of a reader of lines.
Result<bool> wait_for_line(Input& input, RowReader& reader, std::chrono::milliseconds longest);

/// Rays that go out as soon as they came. A batch has those that are there, one at least.
struct LiveRays {
  /// Ends at the end of the rays, and when none came for `kLongestPause`.
  RaySource<double> source;
  /// Waits for the next ray, however long. False: there are no more.
  std::function<Result<bool>()> wait;
};

/// After so long without a ray a source ends; a later source goes on.
inline constexpr std::chrono::seconds kLongestPause{5};

LiveRays live_rays(std::shared_ptr<RowReader> reader);

}  // namespace sightline::client::cli::files
