// The settings of a TOML file, each with its line.
#include "server/settings/settings_file.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <fstream>
#include <set>
#include <sstream>
#include <string_view>
#include <system_error>
#include <utility>

#include "server/exec/rpc_status.h"

namespace sightline::server::settings {
namespace {

bool is_quote(char c) { return c == '"' || c == '\''; }

bool is_key(std::string_view key) {
  return !key.empty() && key.find_first_not_of(
                             "abcdefghijklmnopqrstuvwxyz"
                             "ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-") == key.npos;
}

/// Whether the value is one of those that read_settings() takes. CLI11's reader takes more, and
/// misreads some.
bool is_plain(std::string_view value) {
  if (value.empty()) return false;
  if (!is_quote(value.front())) return value.find_first_of("\"'[]{}, \t") == value.npos;
  const auto end = value.find(value.front(), 1);
  return end + 1 == value.size() && (value.front() == '\'' || value.find('\\') == value.npos);
}

/// Reads the lines of one file in order.
class Reader {
 public:
  explicit Reader(std::filesystem::path path) { file_.path = std::move(path); }

  Status add(const std::string& text) {
    ++line_;
    std::string trimmed = text;
    CLI::detail::trim(trimmed);
    if (trimmed.empty() || trimmed.front() == '#') return {};
    return trimmed.front() == '[' ? begin_table(trimmed) : add_setting(trimmed);
  }

  SettingsFile take() { return std::move(file_); }

 private:
  Status begin_table(std::string text) {
    text = CLI::detail::trim_copy(text.substr(0, text.find('#')));
    const bool is_list = text.starts_with("[[") && text.ends_with("]]");
    const std::size_t brackets = is_list ? 2 : 1;
    if (!text.ends_with(']') || text.size() <= 2 * brackets)
      return file_.error(line_, fmt::format("{} is not [TABLE]", exec::quote(text)));
    table_ = CLI::detail::trim_copy(text.substr(brackets, text.size() - 2 * brackets));
    header_ = line_;
    file_.headers.push_back({.table = table_, .is_list = is_list, .line = line_});
    if (!is_list && !tables_.insert(table_).second)
      return file_.error(line_, fmt::format("the table {} is there twice", exec::quote(table_)));
    return {};
  }

  Status add_setting(const std::string& text) {
    const std::size_t equals = text.find('=');
    std::istringstream input(text);
    const auto items = CLI::ConfigTOML().from_config(input);
    if (equals == text.npos || !is_key(CLI::detail::trim_copy(text.substr(0, equals))) ||
        items.size() != 1 || items.front().inputs.size() != 1 ||
        !is_plain(value_text(text.substr(equals + 1)))) {
      return file_.error(
          line_, fmt::format("{} is not KEY = VALUE, with a number, true, false or a string "
                             "without '#' and escapes",
                             exec::quote(text)));
    }
    Setting setting{.table = table_,
                    .header = header_,
                    .key = items.front().name,
                    .value = items.front().inputs.front(),
                    .line = line_};
    if (!keys_.insert({header_, setting.key}).second)
      return file_.error(line_, fmt::format("{} is set twice", exec::quote(setting.key)));
    file_.settings.push_back(std::move(setting));
    return {};
  }

  /// The text of a value, cut as CLI11 does.
  static std::string value_text(const std::string& text) {
    return CLI::detail::trim_copy(text.substr(0, text.find('#')));
  }

  SettingsFile file_;
  std::size_t line_ = 0, header_ = 0;
  std::string table_;
  std::set<std::string> tables_;
  std::set<std::pair<std::size_t, std::string>> keys_;
};

}  // namespace

Error SettingsFile::error(std::size_t line, const std::string& why) const {
  return {Code::kInvalidArgument, fmt::format("{}:{}: {}", path.string(), line, why), kBadSettings};
}

Result<SettingsFile> read_settings(const std::filesystem::path& path) {
  errno = 0;
  std::ifstream in(path);
  Reader reader(path);
  std::string line;
  while (std::getline(in, line)) {
    if (const Status added = reader.add(line); !added) return added.error();
  }
  if (in.eof()) return reader.take();
  return Error{Code::kNotFound,
               fmt::format("cannot read the settings {}: {}", path.string(),
                           std::generic_category().message(errno)),
               kBadSettings};
}

}  // namespace sightline::server::settings
