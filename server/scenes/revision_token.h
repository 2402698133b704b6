// What a SceneRevision.token says: one revision of one very scene.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "accel/result.h"
#include "sightline/v1/common.pb.h"

namespace sightline::server::scenes {

struct RevisionToken {
  std::uint64_t incarnation = 0;  ///< Of the scene: another one after it was created anew.
  std::uint64_t revision = 0;

  std::string text() const;
  /// Errors: kInvalidArgument for what text() does not make.
  static Result<RevisionToken> parse(std::string_view text);
};

/// Drawn at random, for a scene that is being created.
std::uint64_t new_incarnation();

void encode_revision(const RevisionToken& token, v1::SceneRevision& out);

}  // namespace sightline::server::scenes
