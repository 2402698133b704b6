// The quotas in the file of settings.
#pragma once

#include <string>

#include "proto/result.h"
#include "server/exec/quotas.h"
#include "server/settings/settings_file.h"

namespace sightline::server::settings {

/// Reads the tables of the file: [quota] for each principal that is not named, and one
/// [[quota.principal]] with its `name` for each that is. What a named one does not set it has from
/// [quota]; 0 is no limit. Errors: kInvalidArgument, with the file and the line (another table, an
/// unknown key, not a whole number, a principal without a name or with one that is there twice).
Result<exec::QuotaConfig> read_quotas(const SettingsFile& file);

/// The tables again, each value with its line. The file has been read by read_quotas().
std::string print_quotas(const SettingsFile& file);

}  // namespace sightline::server::settings
