// Flags to a connection, values to text.
#include "client/cli/session.h"

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>

#include "client/cli/arguments.h"

namespace sightline::client::cli {

Result<Client> Session::connect() const {
  ClientOptions options;
  if (deadline) {
    options.timeout = std::chrono::milliseconds(std::llround(std::ceil(*deadline * 1000)));
  }
  return Client::connect(endpoint, options);
}

void print_json(const Json& document) {
  const std::string text = document.dump(2, ' ', false, Json::error_handler_t::replace);
  std::fwrite(text.data(), 1, text.size(), stdout);
  std::fputc('\n', stdout);
}

Json json_of_axis(UpAxis axis) {
  if (axis == UpAxis::kY) return "y";
  if (axis == UpAxis::kZ) return "z";
  return nullptr;
}

Json json_of_unit(double meters_per_unit) {
  return meters_per_unit > 0 ? Json(meters_per_unit) : Json(nullptr);
}

void require_verb(CLI::App& app) {
  // Not App::require_subcommand: its complaint comes first and does not name the word that is no
  // verb.
  app.require_subcommand(0, 1);
  app.callback([&app] {
    if (app.get_subcommands().empty()) throw CLI::RequiredError("A verb");
  });
}

void add_scene_argument(CLI::App& verb, std::string& name) {
  verb.add_option("SCENE", name, "The scene: a name, or projects/PROJECT/scenes/NAME")
      ->required()
      ->transform(CLI::Validator(
          [](std::string& text) -> std::string {
            const auto full = parse_scene_name(text);
            if (!full) {
              return "'" + text +
                     "' is no scene name: 1 to 63 of a-z 0-9 . _ -, the first a letter or digit";
            }
            text = *full;
            return {};
          },
          ""));
}

CLI::Validator positive_number() {
  return CLI::Validator(
      [](std::string& text) -> std::string {
        const auto number = parse_number(text);
        return number && *number > 0 && std::isfinite(*number)
                   ? ""
                   : "'" + text + "' is not a number above 0";
      },
      "");
}

}  // namespace sightline::client::cli
