// What a channel proves and what it asks for: TLS, and the token that goes with each call. Internal
// to the library.
#pragma once

#include <grpcpp/security/credentials.h>
#include <grpcpp/support/client_interceptor.h>

#include <memory>
#include <string>
#include <vector>

#include "client/calls/endpoint.h"
#include "client/client.h"

namespace sightline::client::calls {

struct ChannelCredentials {
  std::shared_ptr<grpc::ChannelCredentials> channel;
  std::string token;  ///< Empty: none.

  /// Errors: kInvalidArgument (a file cannot be read, or the token has other characters than
  /// visible ASCII), kUnauthenticated (TOKEN_IN_PLAINTEXT: the token would leave this machine
  /// without encryption).
  static Result<ChannelCredentials> make(const Endpoint& endpoint, const ClientOptions& options);
};

/// Adds "authorization: Bearer TOKEN" to each call of a channel.
std::vector<std::unique_ptr<grpc::experimental::ClientInterceptorFactoryInterface>> send_token(
    const std::string& token);

/// Whether a message of gRPC says that TLS did not come about: by a certificate, or because the
/// server does not speak it.
bool tells_of_tls(const std::string& message);

}  // namespace sightline::client::calls
