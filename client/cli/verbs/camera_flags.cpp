// The flags of a camera and its picture, which several verbs have.
#include "client/cli/verbs/camera_flags.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

namespace sightline::client::cli::verbs {
namespace {

// An axis by its letter, or any direction.
std::optional<picture::Vec3> parse_up(const std::string& text) {
  if (text == "x") return picture::Vec3{1, 0, 0};
  if (text == "y") return picture::Vec3{0, 1, 0};
  if (text == "z") return picture::Vec3{0, 0, 1};
  const auto vector = parse_vector(text);
  if (!vector || !(picture::length(*vector) > 0)) return std::nullopt;
  return vector;
}

void add_up_option(CLI::App& verb, std::optional<picture::Vec3>& up) {
  verb.add_option_function<std::string>(
          "--up",
          [&up](const std::string& text) {
            up = parse_up(text);
            if (!up) {
              throw CLI::ValidationError(
                  "--up", "'" + text + "' is not x, y, z, or a direction X,Y,Z that is not zero");
            }
          },
          "What is up in the picture (default: the axis that the scene records, or y)")
      ->type_name("x|y|z|X,Y,Z");
}

}  // namespace

void add_vector_option(CLI::App& verb, const std::string& name, std::optional<picture::Vec3>& value,
                       const std::string& help) {
  verb.add_option_function<std::string>(
          name,
          [&value, name](const std::string& text) {
            value = parse_vector(text);
            if (!value) throw CLI::ValidationError(name, "'" + text + "' is not x,y,z");
          },
          help)
      ->type_name("X,Y,Z");
}

void add_size_option(CLI::App& verb, PictureSize& size, const std::string& help) {
  verb.add_option_function<std::string>(
          "--size",
          [&size](const std::string& text) {
            const auto parsed = parse_size(text);
            if (!parsed) {
              throw CLI::ValidationError(
                  "--size",
                  fmt::format("'{}' is not WxH with both from 1 to {}", text, kMaxPictureSide));
            }
            size = *parsed;
          },
          help)
      ->type_name("WxH");
}

void add_camera_flags(CLI::App& verb, picture::CameraRequest& camera, PictureSize& size) {
  add_size_option(verb, size,
                  "Width and height in pixels; four rays a pixel are cast (default 1280x720)");
  add_vector_option(verb, "--eye", camera.eye,
                    "Where the camera is (default: where it sees the whole scene)");
  add_vector_option(verb, "--at", camera.at, "What it looks at (default: the middle of the scene)");
  verb.add_option("--fov", camera.fov,
                  "Degrees from the bottom of the picture to its top (default 40)")
      ->check(CLI::Range(0.01, 179.0).description(""))
      ->type_name("DEGREES");
  add_up_option(verb, camera.up);
}

}  // namespace sightline::client::cli::verbs
