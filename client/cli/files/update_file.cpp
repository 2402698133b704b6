// Files of updates: a JSON object a line.
#include "client/cli/files/update_file.h"

#include <fmt/format.h>

#include <cstddef>
#include <string_view>
#include <utility>

#include "client/cli/files/input.h"
#include "client/cli/files/update_json.h"
#include "client/cli/terminal.h"

namespace sightline::client::cli::files {
namespace {

bool is_blank(std::string_view line) {
  return line.find_first_not_of(" \t\r") == std::string_view::npos;
}

}  // namespace

Result<std::vector<Update>> read_updates(const std::string& file, const std::stop_token& stop) {
  auto input = Input::open(file, stop);
  if (!input) return input.error();
  std::vector<Update> updates;
  std::string_view line;
  for (std::size_t number = 1;; ++number) {
    const auto more = input->next_line(line);
    if (!more) return more.error();
    if (!*more) return updates;
    if (is_blank(line)) continue;
    auto update = parse_update(line);
    if (!update) {
      return local_error(
          fmt::format("{}: line {}: {}", input->name(), number, update.error().message));
    }
    updates.push_back(*std::move(update));
  }
}

}  // namespace sightline::client::cli::files
