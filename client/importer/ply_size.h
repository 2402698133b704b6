// The size that a binary PLY file must have by its header and its lists. Internal to the importer.
#pragma once

#include <cstdint>
#include <string_view>

namespace sightline::client::importer {

/// How many bytes are missing at the end, or a lower bound of them. 0: none, or the file is no
/// binary PLY file with a header that is understood.
std::uint64_t bytes_missing_in_ply(std::string_view file);

}  // namespace sightline::client::importer
