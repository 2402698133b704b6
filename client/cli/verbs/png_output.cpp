// The PNG file of a verb that makes a picture.
#include "client/cli/verbs/png_output.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>

#include "client/cli/files/output.h"
#include "client/cli/picture/picture.h"

namespace sightline::client::cli::verbs {
namespace {

// The name of a file that says what is written, or standard output.
CLI::Validator png_file() {
  return {[](const std::string& path) {
            std::string end = path.substr(path.size() - std::min<std::size_t>(path.size(), 4));
            std::transform(end.begin(), end.end(), end.begin(),
                           [](unsigned char c) { return c < 0x80 ? std::tolower(c) : c; });
            if (path == "-" || (end == ".png" && path.size() > end.size())) return std::string();
            return fmt::format("'{}' does not end with .png: pictures are PNG files", path);
          },
          ""};
}

}  // namespace

void add_png_option(CLI::App& verb, std::string& path) {
  verb.add_option("--out", path, "The PNG file to write, or - for standard output")
      ->required()
      ->check(png_file())
      ->type_name("FILE.png");
}

void check_png_output(const Session& session, const std::string& path) {
  if (session.json && path == "-")
    throw CLI::ValidationError("--json needs a file for --out: both go to standard output");
}

Status write_png(const std::string& path, std::span<const std::uint8_t> rgb, PictureSize size) {
  const auto bytes = picture::encode_png(rgb, size.width, size.height);
  if (!bytes) return bytes.error();
  auto output = files::Output::open(path);
  if (!output) return output.error();
  if (Status wrote = output->write(*bytes); !wrote) return wrote;
  return output->commit();
}

}  // namespace sightline::client::cli::verbs
