// Rays as Radiance's rtrace reads them: six numbers each, as text or in binary.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>

#include "client/cli/files/input.h"
#include "client/cli/files/row_reader.h"
#include "client/result.h"

namespace sightline::client::cli::files {

enum class RtraceNumbers : std::uint8_t { kText, kFloat, kDouble };

struct RtraceEncoding {
  RtraceNumbers in = RtraceNumbers::kText;
  RtraceNumbers out = RtraceNumbers::kText;
};

/// Parses what follows -f: a letter for the rays and one for the hits, each a, f or d; one letter
/// is for both. Errors: kInvalidArgument.
Result<RtraceEncoding> parse_rtrace_encoding(std::string_view letters);

struct RtraceRayOptions {
  RtraceNumbers numbers = RtraceNumbers::kText;
  bool ends_at_direction = false;           ///< a ray is as long as its direction
  std::optional<std::uint64_t> count = {};  ///< how many are read; not set: all
};

/// Text is words parted by blanks, whatever the lines are; binary has the byte order of this
/// machine. Errors of the reader: those of Input; kInvalidArgument, a word that is no number, or an
/// input that ends within a ray.
std::shared_ptr<RowReader> make_rtrace_rays(Input input, const RtraceRayOptions& options);

}  // namespace sightline::client::cli::files
