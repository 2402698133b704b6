// Names of scenes, projects/{project}/scenes/{scene}, and tokens of their revisions.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "proto/result.h"
#include "sightline/v1/common.pb.h"

namespace sightline::server::scenes {

inline constexpr std::size_t kMaxId = 63;  ///< Bytes of a project or scene id.

/// Errors: kInvalidArgument, naming the part that is wrong and what it should match.
Status check_scene_name(std::string_view name);

/// Checks a name projects/{project}. Errors: as check_scene_name().
Status check_project_name(std::string_view name);

/// Stands for the scenes of all projects in a list, as in https://google.aip.dev/159.
inline constexpr std::string_view kAllProjects = "projects/-";

/// The project part, "projects/{project}", of a checked scene name.
std::string_view project_of(std::string_view scene_name);

/// The content of SceneRevision.token: a revision of one scene, until that scene is deleted.
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

/// Writes the number and the token.
void encode_revision(const RevisionToken& token, v1::SceneRevision& out);

}  // namespace sightline::server::scenes
