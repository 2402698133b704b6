// Small value types: vertices, faces, transforms, mobility, labels, up axis, consistency.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>

namespace sightline::client {

using Vertex = std::array<float, 3>;
using Face = std::array<std::uint32_t, 3>;  ///< Indices of vertices.

/// The value of all three indices of a face that holds no triangle. Such a face keeps its number
/// and is never hit.
inline constexpr std::uint32_t kNoVertex = std::numeric_limits<std::uint32_t>::max();

/// Rows of [linear | translation], parent from local.
using Transform = std::array<double, 12>;
inline constexpr Transform kIdentity{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

/// How a node is expected to change.
enum class Mobility : std::uint8_t { kStatic, kRigid, kDeforming };

/// A fact about a node, in UTF-8 without control characters. ServerInfo has the limits.
struct Label {
  std::string key;  ///< not empty, and once for each node
  std::string value;
  bool operator==(const Label&) const = default;
};

/// Matches a node's label with this key and, unless it is not set, this value.
struct LabelMatch {
  std::string key;
  std::optional<std::string> value{};
  bool operator==(const LabelMatch&) const = default;
};

/// The axis that points up in a scene, if it is known.
enum class UpAxis : std::uint8_t { kUnknown, kY, kZ };

/// The revision of a scene that answers a read. At most one of the two is set; with neither, the
/// latest revision answers.
struct Consistency {
  /// The latest revision answers, once it is at least as new as the revision of this token. So the
  /// read sees what was applied. Errors: kInvalidArgument, a token of another scene; kUnavailable,
  /// the revision was not reached within two seconds.
  std::string at_least{};
  /// This revision answers. Errors: kOutOfRange, it does not exist yet or is not kept any more.
  std::optional<std::uint64_t> exact_revision{};
};

}  // namespace sightline::client
