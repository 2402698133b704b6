// A server whose only method says who calls.
#pragma once

#include <grpcpp/channel.h>
#include <grpcpp/security/credentials.h>
#include <grpcpp/security/server_credentials.h>
#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "server/exec/call_context.h"
#include "server/net/acceptor.h"
#include "server/net/listening_sockets.h"

namespace sightline::tests {

class AskingServer {
 public:
  /// What the method answers for a call, or why it refuses.
  using Answer = std::function<Result<std::string>(server::exec::CallContext& context)>;

  /// `address`: as sightlined's --listen. `calls` and what `credentials` use outlive the server.
  AskingServer(
      server::exec::CallContexts& calls, Answer answer, const std::string& address = "127.0.0.1:0",
      std::shared_ptr<grpc::ServerCredentials> credentials = grpc::InsecureServerCredentials());
  ~AskingServer();

  std::uint16_t port() const { return port_; }

  /// A connection of its own.
  std::shared_ptr<grpc::Channel> connect(
      const std::shared_ptr<grpc::ChannelCredentials>& credentials =
          grpc::InsecureChannelCredentials()) const;

 private:
  class Service;

  const std::unique_ptr<Service> service_;
  std::string target_;
  std::uint16_t port_ = 0;
  server::net::SocketFile file_;
  std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor> connections_;
  std::unique_ptr<grpc::Server> grpc_;
  std::unique_ptr<server::net::Acceptor> acceptor_;
};

/// The answer, or the reason of the refusal. `authorization`: the headers of this name.
std::string ask(const std::shared_ptr<grpc::Channel>& channel,
                const std::vector<std::string>& authorization = {});

}  // namespace sightline::tests
