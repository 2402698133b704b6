// The header of a PLY file: which elements follow it, and their properties. Internal to the
// importer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "client/importer/imported_scene.h"
#include "client/result.h"

namespace sightline::client::importer::formats {

enum class PlyType : std::uint8_t {
  kInt8,
  kUint8,
  kInt16,
  kUint16,
  kInt32,
  kUint32,
  kFloat32,
  kFloat64
};

std::size_t bytes_of(PlyType type);

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::kFloat32;  ///< a value's
  bool is_list = false;
  PlyType length_type = PlyType::kUint8;  ///< a list's
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;

  /// The index of a property; properties.size() if there is none.
  std::size_t find(std::string_view property) const;
};

enum class PlyFormat : std::uint8_t { kAscii, kLittleEndian, kBigEndian };

struct PlyHeader {
  PlyFormat format = PlyFormat::kAscii;
  std::vector<PlyElement> elements;
  std::size_t end = 0;          ///< where the elements begin, in bytes
  std::uint64_t next_line = 1;  ///< the number of the line after it
  std::vector<Warning> warnings;
};

/// Types may have their old or their new names. A binary body begins right after the line end of
/// end_header, whatever its first byte is: lines end with CR only if the first one does. Errors:
/// kInvalidArgument: the file does not begin with "ply", the header has no end within a mebibyte,
/// no format, a name that is there twice, or a line that is not understood; it announces more
/// elements than the file has bytes.
Result<PlyHeader> read_ply_header(std::string_view file);

}  // namespace sightline::client::importer::formats
