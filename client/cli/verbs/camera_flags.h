// The flags of a camera and its picture, which several verbs have.
#pragma once

#include "client/cli/flags.h"
#include "client/cli/picture/camera.h"

namespace CLI {
class App;
}

namespace sightline::client::cli::verbs {

/// Adds --size, --eye, --at and --fov. The verb's callback must not outlive `camera` and `size`.
void add_camera_flags(CLI::App& verb, picture::CameraRequest& camera, PictureSize& size);

}  // namespace sightline::client::cli::verbs
