// A file of rays in any supported format, as a source for a cast.
#pragma once

#include <cstdint>
#include <optional>
#include <stop_token>
#include <string>
#include <variant>

#include "client/cast_options.h"
#include "client/result.h"

namespace sightline::client::cli::files {

struct RayFile {
  /// The rays, in the precision of the file.
  std::variant<RaySource<float>, RaySource<double>> source;
  RayShape shape;
  std::optional<std::uint64_t> count;  ///< the number of rays, if the file states it
};

/// Opens a file of rays: .npy of shape (n, 6) or (n, 8), float32 or float64, in either order, or
/// CSV. The first bytes tell the format. "-" is standard input. Errors: kInvalidArgument, naming
/// the file and what is wrong with it; kCancelled, here and from the source, if a stop is requested
/// while the file sends nothing.
Result<RayFile> open_rays(const std::string& path, std::stop_token stop = {});

}  // namespace sightline::client::cli::files
