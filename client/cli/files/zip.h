// Archives of the kind .npz: a few files, packed with deflate or not at all.
#pragma once

#include <cstddef>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "client/result.h"

namespace sightline::client::cli::files {

inline constexpr std::string_view kZipMagic = "PK\x03\x04";

/// The files of an archive, unpacked, by name. Errors: kInvalidArgument, saying what is wrong.
Result<std::map<std::string, std::vector<std::byte>>> unzip(std::span<const std::byte> archive);

struct ZipEntry {
  std::string name;
  std::string bytes;
};

/// An archive of these files, not packed. Errors: kInvalidArgument, one of more than 4 GiB.
Result<std::string> zip(std::span<const ZipEntry> entries);

}  // namespace sightline::client::cli::files
