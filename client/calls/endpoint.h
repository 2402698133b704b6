// Where servers listen: one address, or those of several replicas. Internal to the library.
#pragma once

#include <string>
#include <vector>

#include "client/result.h"

namespace sightline::client::calls {

class Endpoint {
 public:
  /// HOST:PORT, several of these with commas between, or unix:PATH. Errors: kInvalidArgument.
  static Result<Endpoint> parse(const std::string& text);

  /// The text that was parsed.
  const std::string& text() const { return text_; }

  /// Whether what is sent there stays on this machine: unix:PATH, or hosts that are loopback
  /// addresses or "localhost".
  bool is_local() const;

  /// Whether there are several servers, or may be: a name can have several addresses.
  bool is_balanced() const;

  /// What gRPC connects to. A single name is resolved by gRPC, again and again; the names of a list
  /// are resolved here, once. Errors: kUnavailable, a name of a list has no address.
  Result<std::string> target() const;

  /// The name that servers of a list must have in their certificates: the first host. Empty: that
  /// of the target.
  std::string authority() const;

 private:
  struct Address {
    std::string host;  ///< Without brackets.
    std::string port;
  };

  std::string text_;
  std::vector<Address> addresses_;  ///< None: a socket's path.
};

}  // namespace sightline::client::calls
