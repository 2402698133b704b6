// How much of a file there is, its holes left out.
#pragma once

#include <cstdint>

namespace sightline::client::importer::sandbox {

/// Pieces of one file that are looked at.
inline constexpr int kMostPieces = 1024;

/// Bytes of an open file of `size` bytes that are stored: what reads as zero because nothing was
/// ever written there does not count, nor what is only reserved. Compressed bytes count as they are
/// read. All of them where the file system knows no holes. Moves the file's position.
std::uint64_t stored_bytes(int file, std::uint64_t size);

}  // namespace sightline::client::importer::sandbox
