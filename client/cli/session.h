// What all verbs share: the global flags, the connection, and JSON output.
#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "client/cli/terminal.h"
#include "client/client.h"

namespace sightline::client::cli {

/// One run of the command. Verbs read the flags when they run; all arguments are parsed by then.
struct Session {
  std::string endpoint = "127.0.0.1:50151";
  bool json = false;
  bool quiet = false;              ///< no progress, no summaries, no warnings
  std::optional<double> deadline;  ///< seconds that a call may take
  ClientOptions options;           ///< the certificates of the connection
  std::string token_file;          ///< empty: the token is in the environment, if there is one
  std::string command;             ///< as typed, for reports
  ExitCode exit = kOk;             ///< the result of the verb

  /// Errors: those of Client::connect(); kInvalidArgument, the token cannot be read.
  Result<Client> connect() const;
};

using Json = nlohmann::ordered_json;

/// The document, indented by `indent` characters a level; on one line if that is below 0. Without
/// effect on a terminal: all control characters are escaped, those that JSON allows too.
std::string json_text(const Json& document, int indent);

/// Prints one document on stdout.
void print_json(const Json& document);

/// "y", "z" or null.
Json json_of_axis(UpAxis axis);

/// A positive number, or null for what is unknown.
Json json_of_unit(double meters_per_unit);

}  // namespace sightline::client::cli
