// Checks the importer's guarantees on one scene in Assimp's form.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace sightline::tests {

/// Describes an error in the import of the scene that the bytes make, or nothing. `taken` is set to
/// whether it accepted the scene with its animations.
std::optional<std::string> check_made(std::span<const std::uint8_t> bytes, bool* taken = nullptr);

}  // namespace sightline::tests
