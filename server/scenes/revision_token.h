// The content of SceneRevision.token: a revision of one scene, until that scene is deleted.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "accel/result.h"
#include "sightline/v1/common.pb.h"

namespace sightline::server::scenes {

struct RevisionToken {
  std::uint64_t incarnation = 0;  ///< Random number of the scene. A scene created again under the
                                  ///< same name has another one.
  std::uint64_t revision = 0;

  std::string text() const;
  /// Errors: kInvalidArgument if text() cannot have made it.
  static Result<RevisionToken> parse(std::string_view text);
};

/// A random number for a new scene.
std::uint64_t new_incarnation();

void encode_revision(const RevisionToken& token, v1::SceneRevision& out);

}  // namespace sightline::server::scenes
