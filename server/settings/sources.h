// Settings that a flag has not set: from the environment, or else from a file.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "proto/result.h"
#include "server/settings/settings_file.h"

namespace CLI {
class App;
}

namespace sightline::server::settings {

/// Where the values of settings came from, by the name of the setting: "flag", "environment NAME"
/// or "file PATH:LINE". A setting that is not here has its default.
using Sources = std::map<std::string, std::string>;

/// The environment variable of the setting "some-name": SIGHTLINED_SOME_NAME.
std::string variable_of(const std::string& setting);

/// Sets every option of `app`, which has parsed its flags, that no flag has set: to the value of
/// its environment variable, unless that is empty, or else of the file's setting outside of tables.
/// A setting has the name of its flag. Flags that only ask for output (`app`'s configurable(false))
/// are no settings. Errors: kInvalidArgument, naming the variable, or the file and the line: a
/// setting that does not exist, or a value that is wrong.
Result<Sources> set_from_sources(CLI::App& app, const SettingsFile& file);

/// The text for the value of a setting, which may be a secret.
using ShowSetting =
    std::function<std::string(const std::string& setting, const std::string& value)>;

/// All settings of `app` as TOML, each with its source in a comment.
std::string print_settings(const CLI::App& app, const Sources& sources, const ShowSetting& show);

/// A value as TOML: numbers, true and false as they are, anything else as a string.
std::string to_toml(const std::string& value);
std::string to_toml_string(const std::string& text);

/// The environment variables that look like settings and are none, of a process with the
/// environment `environment` (as `environ`).
std::vector<std::string> unknown_variables(const CLI::App& app, const char* const* environment);

}  // namespace sightline::server::settings
