// The quotas in the file of settings.
#include "server/settings/quota_settings.h"

#include <fmt/format.h>

#include <charconv>
#include <map>
#include <optional>
#include <string_view>

#include "server/exec/rpc_status.h"
#include "server/settings/byte_size.h"
#include "server/settings/sources.h"

namespace sightline::server::settings {
namespace {

using exec::Quota;
using exec::QuotaLimits;

constexpr const char* kOthersTable = "quota";
constexpr const char* kPrincipalTable = "quota.principal";
constexpr const char* kName = "name";
constexpr Quota kAll[] = {Quota::kRays, Quota::kBytes, Quota::kWork, Quota::kStored};

std::optional<Quota> quota_of(const std::string& key) {
  for (const Quota quota : kAll) {
    if (key == exec::quota_name(quota)) return quota;
  }
  return std::nullopt;
}

Status set_quota(const SettingsFile& file, const Setting& setting, QuotaLimits& limits) {
  const auto quota = quota_of(setting.key);
  if (!quota)
    return file.error(setting.line, fmt::format("there is no quota {}", exec::quote(setting.key)));
  std::uint64_t& limit = limits[static_cast<std::size_t>(*quota)];
  if (*quota == Quota::kBytes || *quota == Quota::kStored) {
    const auto bytes = parse_byte_size(setting.value, 0);
    if (!bytes) return file.error(setting.line, bytes.error().message);
    limit = *bytes;
    return {};
  }
  const char* end = setting.value.data() + setting.value.size();
  const auto [parsed_to, error] = std::from_chars(setting.value.data(), end, limit);
  if (error == std::errc{} && parsed_to == end) return {};
  return file.error(setting.line,
                    fmt::format("{} is not a whole number", exec::quote(setting.value)));
}

/// The names of the principals, by the line of the table's header.
Result<std::map<std::size_t, std::string>> names_of(const SettingsFile& file) {
  std::map<std::size_t, std::string> names;
  std::map<std::string, std::size_t> lines;
  for (const Setting& setting : file.settings) {
    if (setting.table != kPrincipalTable || setting.key != kName) continue;
    const auto [first, is_new] = lines.emplace(setting.value, setting.line);
    if (!is_new) {
      return file.error(setting.line, fmt::format("the principal {} is also in line {}",
                                                  exec::quote(setting.value), first->second));
    }
    names.emplace(setting.header, setting.value);
  }
  return names;
}

/// Errors: a table that does not exist, a principal without a name; also where they are empty.
Status check_tables(const SettingsFile& file, const std::map<std::size_t, std::string>& names) {
  for (const auto& [table, is_list, line] : file.headers) {
    const std::string_view known = is_list ? kPrincipalTable : kOthersTable;
    if (table != known) {
      return file.error(
          line, fmt::format("there is no {} {}", is_list ? "list" : "table", exec::quote(table)));
    }
    if (is_list && !names.contains(line)) return file.error(line, "the principal has no name");
  }
  return {};
}

}  // namespace

Result<exec::QuotaConfig> read_quotas(const SettingsFile& file) {
  const auto names = names_of(file);
  if (!names) return names.error();
  if (const Status known = check_tables(file, *names); !known) return known.error();
  exec::QuotaConfig quotas;
  for (const Setting& setting : file.settings) {
    if (setting.table != kOthersTable) continue;
    if (const Status done = set_quota(file, setting, quotas.others); !done) return done.error();
  }
  for (const Setting& setting : file.settings) {
    if (setting.table != kPrincipalTable) continue;
    QuotaLimits& limits =
        quotas.principals.try_emplace(names->at(setting.header), quotas.others).first->second;
    if (setting.key == kName) continue;
    if (const Status done = set_quota(file, setting, limits); !done) return done.error();
  }
  return quotas;
}

std::string print_quotas(const SettingsFile& file) {
  std::string out;
  std::size_t header = 0;
  for (const Setting& setting : file.settings) {
    if (setting.table.empty()) continue;
    if (setting.header != header)
      out += setting.table == kOthersTable ? "\n[quota]\n" : "\n[[quota.principal]]\n";
    header = setting.header;
    const bool is_name = setting.key == kName;
    out += fmt::format("{} = {}  # file {}:{}\n", setting.key,
                       is_name ? to_toml_string(setting.value) : to_toml(setting.value),
                       file.path.string(), setting.line);
  }
  return out;
}

}  // namespace sightline::server::settings
