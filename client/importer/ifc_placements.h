// Where an IFC file puts its products, and its unit of length. Internal to the importer.
#pragma once

#include <string_view>
#include <unordered_map>

#include "client/importer/ifc_statements.h"

namespace sightline::client::importer {

/// How far Assimp moves products as it composes their placements in float32, by their GlobalIds, in
/// the file's unit.
std::unordered_map<std::string_view, double> ifc_losses(const Statements& statements);

/// How many meters Assimp's unit of length is: 1, as it converts SI units, or that of a unit that
/// is based on another one, such as feet, which it does not convert. 0: the file does not say.
double ifc_meters_per_unit(const Statements& statements);

}  // namespace sightline::client::importer
