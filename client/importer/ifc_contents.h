// What an IFC file says of its products, and Assimp does not tell. Internal to the importer.
#pragma once

#include <cstdint>
#include <string_view>
#include <unordered_set>

namespace sightline::client::importer {

struct IfcContents {
  /// The GlobalIds of the products whose body consists of solids alone: extruded, swept or revolved
  /// areas, boundary representations, closed shells, and what is cut out of them. They are parts of
  /// the file.
  std::unordered_set<std::string_view> solids;
  /// Faces that are too small for Assimp, which leaves them out, or that have such a hole, which it
  /// fills
  std::uint64_t lost_faces = 0;
  std::uint64_t first_lost = 0;  ///< the number of such a statement
};

/// `step` is the contents of the file. What is not understood is no solid, and not lost.
IfcContents ifc_contents(std::string_view step);

}  // namespace sightline::client::importer
