// The one conversion from what a reader found to the imported scene. Internal to the importer.
#pragma once

#include "client/importer/animation.h"
#include "client/importer/file_scene.h"
#include "client/importer/imported_scene.h"
#include "client/result.h"

namespace sightline::client::importer {

/// Applies the rest pose (rest_pose.h), cleans names, gives a node of several meshes a child for
/// each, cuts polygons into triangles, brings the scene into the frame that is asked for, moves it
/// near the origin (rebase.h), and rounds vertices to float. Animations that move nothing are
/// dropped. Errors: kInvalidArgument: an index out of range, a transform or a weight that is not
/// finite, or not once it is scaled; keys that are not finite or not in order of time, a duration
/// that is not finite; an offset that is asked for and cannot be moved into the nodes.
Result<AnimatedScene> scene_from_file(FileScene file, const ImportOptions& options);

}  // namespace sightline::client::importer
