// What to do about an error of the server, or about words that the command does not know.
#pragma once

#include <string>

#include "client/result.h"

namespace CLI {
class App;
class ParseError;
}  // namespace CLI

namespace sightline::client::cli {

struct Session;

/// Asks the server for the names of its scenes where one of them may have been meant. Empty: none.
std::string hint_for(const Session& session, const Error& error);

struct UsageError {
  std::string message;
  std::string hint;  ///< may be empty
};

/// What is wrong with a command line, after parsing has failed.
UsageError usage_error_of(const CLI::App& program, const CLI::ParseError& error);

}  // namespace sightline::client::cli
