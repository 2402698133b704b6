// Hits as Radiance's rtrace writes them: a record a ray, of what the letters of -o ask for.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "client/cast_options.h"
#include "client/cli/files/hit_format.h"
#include "client/cli/files/rtrace_rays.h"
#include "client/result.h"

namespace sightline::client::cli::files {

/// Checks the letters of -o. Errors: kInvalidArgument, naming the letter and those that are known.
Status check_rtrace_letters(std::string_view letters);

/// The fields that the letters need.
HitFields rtrace_fields(std::string_view letters);

struct RtraceHitOptions {
  std::string letters;
  RtraceNumbers numbers = RtraceNumbers::kText;
  bool header = true;
  std::string command = {};  ///< for the header
  /// Width and height; with both, a line of them comes before the records.
  std::pair<std::uint32_t, std::uint32_t> size = {};
  std::unordered_map<std::uint64_t, std::string> names = {};  ///< nodes' names, for the letter s
};

/// A ray that hits nothing or cannot be cast has a distance of 1e10, zeros for a point and a
/// normal, and * for a name.
std::unique_ptr<HitFormat> make_rtrace_hits(RtraceHitOptions options);

}  // namespace sightline::client::cli::files
