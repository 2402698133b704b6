// The PNG file of a verb that makes a picture.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "client/cli/flags.h"
#include "client/cli/session.h"
#include "client/result.h"

namespace CLI {
class App;
}

namespace sightline::client::cli::verbs {

/// Adds --out, which is required. `path` receives its value, and must live until the program has
/// been parsed.
void add_png_option(CLI::App& verb, std::string& path);

/// Throws a CLI11 error, which is a usage error, if --json and the picture both want standard
/// output.
void check_png_output(const Session& session, const std::string& path);

/// `rgb`: sRGB, (height, width, 3). Errors: those of encode_png() and of the file.
Status write_png(const std::string& path, std::span<const std::uint8_t> rgb, PictureSize size);

}  // namespace sightline::client::cli::verbs
