// A file of rays or points in any supported format, as a source for a cast.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <variant>
#include <vector>

#include "client/cast_options.h"
#include "client/cli/files/row_layout.h"
#include "client/points.h"
#include "client/result.h"

namespace sightline::client::cli::files {

class RowReader;

struct RayFile {
  /// The rays: float if all of them are float32, else double. Points fill origins and, if `shape`
  /// has the interval, tmax; their buffers have no other columns.
  std::variant<RaySource<float>, RaySource<double>> source;
  RayShape shape;
  std::optional<std::uint64_t> count;  ///< the number of rays, if the file states it
  /// The shape of the array of rays, e.g. (height, width); empty if the file has none.
  std::vector<std::uint64_t> array_shape{};
  /// For rays that come line by line: waits for the next. False: there are no more. The source ends
  /// at the end, and earlier if no ray came for kLongestPause; it goes on when it is read again.
  std::function<Result<bool>()> wait{};
};

/// The points of such a source, which must outlive them.
template <class Scalar>
PointSource<Scalar> as_points(const RaySource<Scalar>& source) {
  return [&source](const PointColumns<Scalar>& buffer) {
    return source({buffer.positions, {}, {}, buffer.max_distance, buffer.masks});
  };
}

/// Rays that come one by one, from a reader.
RayFile live_ray_file(std::shared_ptr<RowReader> reader, bool has_interval);

/// Makes the source of rays that come one by one end only where the rays do.
void wait_out_pauses(RayFile& file);

/// Opens a file of rays: an array of real numbers of shape (..., 6) or (..., 8) in .npy or .npz,
/// the latter also with `origins` and `directions`; .ply; lines of JSON; or CSV. The first bytes
/// tell the format, "-" is standard input. Errors: kInvalidArgument, naming the file and what is
/// wrong with it, also its suffix; kCancelled, here and from the source, if a stop is requested
/// while the file sends nothing.
Result<RayFile> open_rays(const std::string& path, std::stop_token stop = {});
/// As open_rays(), a file of points: of shape (..., 3) or (..., 4), or `positions` and `max`.
Result<RayFile> open_points(const std::string& path, std::stop_token stop = {});
Result<RayFile> open_rows(const std::string& path, RowKind kind, std::stop_token stop = {});

}  // namespace sightline::client::cli::files
