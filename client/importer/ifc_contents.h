// What an IFC file says of its products, and Assimp does not tell. Internal to the importer.
#pragma once

#include <cstdint>
#include <string_view>
#include <unordered_set>

#include "client/importer/ifc_statements.h"

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
  /// Corners that Assimp takes for their neighbors, as they are near for the size of their shell
  std::uint64_t merged_corners = 0;
  std::uint64_t first_merged = 0;  ///< the number of such a shell
  /// Statements with a number that another one has or that stand in a string, and names of
  /// statements that are not there
  std::uint64_t loose_ends = 0;
  std::uint64_t first_loose = 0;  ///< the least such number
};

/// What is not understood is no solid, and not lost.
IfcContents ifc_contents(const Statements& statements);

}  // namespace sightline::client::importer
