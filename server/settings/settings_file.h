// The settings of a TOML file, each with its line.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "proto/result.h"

namespace sightline::server::settings {

/// The reason of all errors of settings.
inline constexpr const char* kBadSettings = "BAD_SETTINGS";

/// One KEY = VALUE.
struct Setting {
  std::string table;       ///< The table that it is in, "a.b" of [a.b] and of [[a.b]]. Empty: none.
  std::size_t header = 0;  ///< The line of the table's header: tables of a list differ in it.
  std::string key;
  std::string value;     ///< Without quotes and escapes.
  std::size_t line = 0;  ///< From 1.
};

/// The header of a table, [a.b] or [[a.b]].
struct TableHeader {
  std::string table;     ///< "a.b".
  bool is_list = false;  ///< [[a.b]].
  std::size_t line = 0;  ///< From 1.
};

/// A file that was read.
struct SettingsFile {
  std::filesystem::path path;
  std::vector<Setting> settings;     ///< In the order of the file.
  std::vector<TableHeader> headers;  ///< In the order of the file, also of empty tables.

  /// An error (kInvalidArgument) with the file, the line and why.
  Error error(std::size_t line, const std::string& why) const;
};

/// Reads a file of TOML of at most 1 MiB. A value is a number, true, false or a string without
/// control characters; tables have headers. Errors: kInvalidArgument, naming the file and the line
/// (not TOML, another value); kNotFound, if the file cannot be read.
Result<SettingsFile> read_settings(const std::filesystem::path& path);

}  // namespace sightline::server::settings
