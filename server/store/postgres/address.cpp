// Where a PostgreSQL database is, and how to log in there.
#include "server/store/postgres/address.h"

#include <libpq-fe.h>

#include <algorithm>
#include <array>
#include <memory>

namespace sightline::server::store::postgres {
namespace {

struct FreeOptions {
  void operator()(PQconninfoOption* options) const { PQconninfoFree(options); }
};

/// What the address may overrule: a server that does not answer is given up soon, also where its
/// machine has gone.
constexpr std::array<std::pair<const char*, const char*>, 5> kDefaults{{
    {"connect_timeout", "3"},
    {"keepalives_idle", "5"},
    {"keepalives_interval", "2"},
    {"keepalives_count", "3"},
    {"tcp_user_timeout", "10000"},
}};
/// What the address may not overrule.
constexpr std::array<std::pair<const char*, const char*>, 3> kFixed{{
    {"target_session_attrs", "read-write"},
    {"application_name", "sightlined"},
    {"client_encoding", "UTF8"},
}};

Error bad_store(const char* why) {
  return {Code::kInvalidArgument,
          std::string(why) + "; write postgresql://USER@HOST:PORT,HOST:PORT/DATABASE", "BAD_STORE"};
}

/// One entry for each host, as libpq pairs them: a single port is that of all.
std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == ',') {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

}  // namespace

Result<Address> Address::parse(std::string_view uri) {
  if (!uri.starts_with("postgresql://") && !uri.starts_with("postgres://"))
    return bad_store("the store does not begin with postgresql://");
  // What libpq says about a wrong text quotes it, with its password.
  char* ignored = nullptr;
  const std::unique_ptr<PQconninfoOption, FreeOptions> options(
      PQconninfoParse(std::string(uri).c_str(), &ignored));
  PQfreemem(ignored);
  if (!options) return bad_store("the address of the store cannot be parsed");
  Address address;
  for (const PQconninfoOption* option = options.get(); option->keyword != nullptr; ++option) {
    if (option->val != nullptr) address.parameters_.emplace_back(option->keyword, option->val);
  }
  for (const auto& [name, value] : kDefaults) {
    if (address.value_of(name).empty()) address.parameters_.emplace_back(name, value);
  }
  for (const auto& [name, value] : kFixed) {
    std::erase_if(address.parameters_, [&](const auto& one) { return one.first == name; });
    address.parameters_.emplace_back(name, value);
  }
  return address;
}

std::string hide_password(std::string_view uri) {
  const auto address = Address::parse(uri);
  if (!address) return "postgresql://...";
  std::string shown(uri);
  const std::size_t user = shown.find("//") + 2;
  const std::size_t at = shown.find('@', user);
  const std::size_t colon = shown.find(':', user);
  if (at != shown.npos && colon < at) shown.erase(colon, at - colon);
  // A password among the names and values, perhaps written with escapes: nothing of them is shown.
  const auto again = Address::parse(shown);
  const auto has_secret = [](const auto& parameter) {
    return parameter.first.ends_with("password") && !parameter.second.empty();
  };
  const bool hidden = again && std::ranges::none_of(again->parameters(), has_secret);
  return hidden ? shown : address->text();
}

std::string Address::value_of(std::string_view name) const {
  const auto found =
      std::ranges::find(parameters_, name, &std::pair<std::string, std::string>::first);
  return found == parameters_.end() ? std::string() : found->second;
}

std::string Address::text() const {
  std::string text = "postgresql://";
  if (const std::string user = value_of("user"); !user.empty()) text += user + "@";
  const auto hosts = split(value_of("host"));
  const auto ports = split(value_of("port"));
  for (std::size_t i = 0; i < hosts.size(); ++i) {
    const std::string& port = ports[std::min(i, ports.size() - 1)];
    text += (i == 0 ? "" : ",") + hosts[i] + (port.empty() ? "" : ":" + port);
  }
  return text + "/" + value_of("dbname");
}

}  // namespace sightline::server::store::postgres
