// Settings that a flag has not set: from the environment, or else from a file.
#include "server/settings/sources.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <string_view>

#include "server/exec/rpc_status.h"

namespace sightline::server::settings {
namespace {

constexpr std::string_view kPrefix = "SIGHTLINED_";

/// The setting of an option; empty if it is none.
std::string setting_of(const CLI::Option& option) {
  if (!option.get_configurable() || option.get_lnames().empty()) return {};
  return option.get_lnames().front();
}

CLI::Option* find_option(CLI::App& app, const std::string& setting) {
  for (CLI::Option* option : app.get_options()) {
    if (!setting.empty() && setting_of(*option) == setting) return option;
  }
  return nullptr;
}

bool is_flag(const CLI::Option& option) { return option.get_expected_min() == 0; }

/// Errors: why the value is wrong, with `source` before it.
Status set_option(CLI::Option& option, const std::string& value, const std::string& source) {
  if (is_flag(option) && value != "true" && value != "false") {
    return exec::invalid_argument(
        fmt::format("{}: {} is neither true nor false", source, exec::quote(value)), kBadSettings);
  }
  try {
    const std::string setting = setting_of(option);
    option.add_result(is_flag(option) ? option.get_flag_value(setting, value) : value);
    option.run_callback();
    return {};
  } catch (const CLI::Error& error) {
    return exec::invalid_argument(fmt::format("{}: {}", source, error.what()), kBadSettings);
  }
}

}  // namespace

std::string variable_of(const std::string& setting) {
  std::string name(kPrefix);
  for (const char c : setting)
    name += c == '-' ? '_' : static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return name;
}

Result<Sources> set_from_sources(CLI::App& app, const SettingsFile& file) {
  Sources sources;
  for (const CLI::Option* option : app.get_options()) {
    if (option->count() > 0) sources[setting_of(*option)] = "flag";
  }
  for (CLI::Option* option : app.get_options()) {
    const std::string setting = setting_of(*option);
    if (setting.empty() || option->count() > 0) continue;
    const std::string variable = variable_of(setting);
    // NOLINTNEXTLINE(concurrency-mt-unsafe): nothing changes the environment
    const char* value = std::getenv(variable.c_str());
    if (value == nullptr || *value == '\0') continue;
    if (const Status done = set_option(*option, value, variable); !done) return done.error();
    sources[setting] = "environment " + variable;
  }
  for (const Setting& entry : file.settings) {
    if (!entry.table.empty()) continue;
    CLI::Option* option = find_option(app, entry.key);
    if (option == nullptr)
      return file.error(entry.line, fmt::format("there is no setting {}", exec::quote(entry.key)));
    const std::string source = fmt::format("{}:{}", file.path.string(), entry.line);
    if (sources.contains(entry.key)) continue;
    if (const Status done = set_option(*option, entry.value, source); !done) return done.error();
    sources[entry.key] = "file " + source;
  }
  return sources;
}

std::string to_toml(const std::string& value) {
  const bool is_number = !value.empty() && std::all_of(value.begin(), value.end(),
                                                       [](char c) { return c >= '0' && c <= '9'; });
  return is_number || value == "true" || value == "false" ? value : to_toml_string(value);
}

std::string to_toml_string(const std::string& text) {
  if (text.find_first_of("\"\\") != text.npos && text.find('\'') == text.npos)
    return "'" + text + "'";
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + '"';
}

std::string print_settings(const CLI::App& app, const Sources& sources, const ShowSetting& show) {
  std::string out;
  for (const CLI::Option* option : app.get_options()) {
    const std::string setting = setting_of(*option);
    if (setting.empty()) continue;
    const auto source = sources.find(setting);
    std::string value = option->count() > 0 ? option->results().back() : option->get_default_str();
    if (value.empty() && is_flag(*option)) value = "false";
    if (value.empty()) {
      out += fmt::format("# {} is not set\n", setting);
    } else {
      out += fmt::format("{} = {}  # {}\n", setting, to_toml(show(setting, value)),
                         source == sources.end() ? "default" : source->second);
    }
  }
  return out;
}

std::vector<std::string> unknown_variables(const CLI::App& app, const char* const* environment) {
  std::vector<std::string> unknown;
  const auto options = app.get_options();
  for (; *environment != nullptr; ++environment) {
    const std::string_view entry = *environment;
    const std::string name(entry.substr(0, entry.find('=')));
    if (!name.starts_with(kPrefix)) continue;
    const bool known = std::any_of(options.begin(), options.end(), [&](const CLI::Option* option) {
      return variable_of(setting_of(*option)) == name;
    });
    if (!known) unknown.push_back(name);
  }
  return unknown;
}

}  // namespace sightline::server::settings
