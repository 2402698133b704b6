// Where a PostgreSQL database is, and how to log in there.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "proto/result.h"

namespace sightline::server::store::postgres {

/// An address may hold a password, which text() does not show.
class Address {
 public:
  /// `uri`: postgresql://[USER[:PASSWORD]@]HOST[:PORT][,HOST[:PORT]...]/[DATABASE][?NAME=VALUE...],
  /// as libpq defines it. The host that takes writes is used. What it leaves out comes from libpq's
  /// environment and password file. Errors: kInvalidArgument (BAD_STORE), which never shows the
  /// text.
  static Result<Address> parse(std::string_view uri);

  /// The address for people: postgresql://USER@HOST:PORT,.../DATABASE.
  std::string text() const;

  /// The names and values for libpq.
  const std::vector<std::pair<std::string, std::string>>& parameters() const { return parameters_; }

 private:
  std::string value_of(std::string_view name) const;

  std::vector<std::pair<std::string, std::string>> parameters_;
};

/// The text of an address without its passwords, for people. One that cannot be parsed is not
/// shown.
std::string hide_password(std::string_view uri);

}  // namespace sightline::server::store::postgres
