// The importer held to its word on one scene in Assimp's form.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace sightline::tests {

/// What is wrong with what the importer makes of the scene that the bytes make, or nothing. `taken`
/// says whether it took the scene, animations and all.
std::optional<std::string> check_made(std::span<const std::uint8_t> bytes, bool* taken = nullptr);

}  // namespace sightline::tests
