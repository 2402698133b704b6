// The flags of a camera and its picture, which several verbs have.
#pragma once

#include <optional>
#include <string>

#include "client/cli/flags.h"
#include "client/cli/picture/camera.h"

namespace CLI {
class App;
}

namespace sightline::client::cli::verbs {

/// Adds an option that takes X,Y,Z. The verb's callback must not outlive `value`.
void add_vector_option(CLI::App& verb, const std::string& name, std::optional<picture::Vec3>& value,
                       const std::string& help);

/// Adds --size. The verb's callback must not outlive `size`.
void add_size_option(CLI::App& verb, PictureSize& size, const std::string& help);

/// Adds --size, --eye, --at and --fov. The verb's callback must not outlive `camera` and `size`.
void add_camera_flags(CLI::App& verb, picture::CameraRequest& camera, PictureSize& size);

}  // namespace sightline::client::cli::verbs
