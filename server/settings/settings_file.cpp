// The settings of a TOML file, each with its line.
#include "server/settings/settings_file.h"

#include <fmt/format.h>

#include <toml++/toml.h>
#include <algorithm>
#include <cerrno>
#include <fstream>
#include <functional>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

#include "server/exec/rpc_status.h"

namespace sightline::server::settings {
namespace {

/// Bytes of a file at most.
constexpr std::size_t kMostBytes = std::size_t{1} << 20;

std::size_t line_of(const toml::node& node) { return node.source().begin.line; }

/// The text of a value; nothing for one that no setting has.
std::optional<std::string> text_of(const toml::node& value) {
  if (const auto* text = value.as_string()) return text->get();
  if (const auto* number = value.as_integer()) return std::to_string(number->get());
  if (const auto* number = value.as_floating_point()) return fmt::format("{}", number->get());
  if (const auto* flag = value.as_boolean()) return flag->get() ? "true" : "false";
  return {};
}

bool is_control(char c) { return static_cast<unsigned char>(c) < ' ' || c == '\x7f'; }

/// Gathers the settings of a table, and of the tables in it.
class Gatherer {
 public:
  explicit Gatherer(SettingsFile& file) : file_(file) {}

  /// `name`: of the table; empty: the file itself.
  Status add(const toml::table& table, const std::string& name, bool is_list) {
    const std::size_t header = name.empty() ? 0 : line_of(table);
    // Several in one line would have the same header.
    if (table.is_inline()) {
      return file_.error(header,
                         fmt::format("{} has braces: write its header in brackets, and each "
                                     "setting on a line of its own",
                                     exec::quote(name)));
    }
    if (!name.empty()) file_.headers.push_back({.table = name, .is_list = is_list, .line = header});
    for (const auto& [key, value] : table) {
      const std::string inner =
          name.empty() ? std::string(key.str()) : fmt::format("{}.{}", name, key.str());
      Status added;
      if (const toml::table* one = value.as_table()) {
        added = add(*one, inner, false);
      } else if (value.is_array_of_tables()) {
        added = add_list(*value.as_array(), inner);
      } else {
        added = add_value(value, {name, header, std::string(key.str()), {}, 0});
      }
      if (!added) return added;
    }
    return {};
  }

 private:
  Status add_list(const toml::array& tables, const std::string& name) {
    for (const toml::node& table : tables) {
      if (Status added = add(*table.as_table(), name, true); !added) return added;
    }
    return {};
  }

  Status add_value(const toml::node& value, Setting setting) {
    setting.line = line_of(value);
    auto text = text_of(value);
    if (!text || std::ranges::any_of(*text, is_control)) {
      return file_.error(setting.line,
                         fmt::format("{} is neither a number, true or false, nor a string without "
                                     "control characters",
                                     exec::quote(setting.key)));
    }
    setting.value = *std::move(text);
    file_.settings.push_back(std::move(setting));
    return {};
  }

  SettingsFile& file_;
};

Result<std::string> content_of(const std::filesystem::path& path) {
  errno = 0;
  std::ifstream in(path, std::ios::binary);
  std::string content(kMostBytes + 1, '\0');
  in.read(content.data(), static_cast<std::streamsize>(content.size()));
  content.resize(static_cast<std::size_t>(in.gcount()));
  std::string why;
  if (!in.eof())
    why = in ? fmt::format("it has more than {} bytes", kMostBytes)
             : std::generic_category().message(errno);
  if (why.empty()) return content;
  return Error{Code::kNotFound, fmt::format("cannot read the settings {}: {}", path.string(), why),
               kBadSettings};
}

}  // namespace

Error SettingsFile::error(std::size_t line, const std::string& why) const {
  return {Code::kInvalidArgument, fmt::format("{}:{}: {}", path.string(), line, why), kBadSettings};
}

Result<SettingsFile> read_settings(const std::filesystem::path& path) {
  const auto content = content_of(path);
  if (!content) return content.error();
  SettingsFile file{.path = path, .settings = {}, .headers = {}};
  try {
    const Status gathered = Gatherer(file).add(toml::parse(*content), {}, false);
    if (!gathered) return gathered.error();
  } catch (const toml::parse_error& error) {
    return file.error(error.source().begin.line, std::string(error.description()));
  }
  // toml++ sorts keys by their names.
  std::ranges::stable_sort(file.settings, {}, &Setting::line);
  std::ranges::stable_sort(file.headers, {}, &TableHeader::line);
  return file;
}

}  // namespace sightline::server::settings
