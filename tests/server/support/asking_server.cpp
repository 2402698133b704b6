// A server whose only method says who calls.
#include "tests/server/support/asking_server.h"

#include <fmt/format.h>
#include <grpc/grpc.h>
#include <grpcpp/client_context.h>
#include <grpcpp/create_channel.h>
#include <gtest/gtest.h>
#include <sightline/v1/server.grpc.pb.h>

#include <chrono>
#include <utility>

#include "server/exec/rpc_status.h"
#include "server/net/listen_address.h"
#include "tests/server/support/api.h"

namespace sightline::tests {

class AskingServer::Service final : public v1::ServerService::CallbackService {
 public:
  explicit Service(Answer answer) : answer_(std::move(answer)) {}

  grpc::ServerUnaryReactor* GetServerInfo(grpc::CallbackServerContext* context,
                                          const v1::GetServerInfoRequest*,
                                          v1::GetServerInfoResponse* reply) override {
    const auto answer = answer_(static_cast<server::exec::CallContext&>(*context));
    if (answer) reply->set_version(*answer);
    auto* reactor = context->DefaultReactor();
    reactor->Finish(answer ? grpc::Status() : server::exec::to_grpc(answer.error()));
    return reactor;
  }

 private:
  const Answer answer_;
};

AskingServer::AskingServer(server::exec::CallContexts& calls, Answer answer,
                           const std::string& address,
                           std::shared_ptr<grpc::ServerCredentials> credentials)
    : service_(std::make_unique<Service>(std::move(answer))) {
  // Never released: see connect() of live_server.cpp.
  static const bool library_held = (grpc_init(), true);
  static_cast<void>(library_held);
  auto listening = server::net::listen_on(*server::net::ListenAddress::parse(address));
  EXPECT_TRUE(listening) << listening.error().message;
  port_ = listening->port;
  file_ = std::move(listening->file);
  target_ = port_ == 0 ? address : fmt::format("127.0.0.1:{}", port_);
  grpc::ServerBuilder builder;
  builder.RegisterService(service_.get());
  builder.SetContextAllocator(server::exec::make_contexts(calls));
  using Type = grpc::ServerBuilder::experimental_type::ExternalConnectionType;
  connections_ =
      builder.experimental().AddExternalConnectionAcceptor(Type::FROM_FD, std::move(credentials));
  grpc_ = builder.BuildAndStart();
  const auto accepted = [this](int listener, server::net::Descriptor connection) {
    grpc::experimental::ExternalConnectionAcceptor::NewConnectionParameters parameters;
    parameters.listener_fd = listener;
    parameters.fd = connection.release();
    connections_->HandleNewConnection(&parameters);
  };
  constexpr std::size_t kConnections = 10;
  acceptor_ = std::make_unique<server::net::Acceptor>(
      std::move(listening->sockets), kConnections,
      server::net::Acceptor::Events{.accepted = accepted, .failed = [] {}});
}

AskingServer::~AskingServer() {
  acceptor_->stop();
  grpc_->Shutdown(std::chrono::system_clock::now());
}

std::shared_ptr<grpc::Channel> AskingServer::connect(
    const std::shared_ptr<grpc::ChannelCredentials>& credentials) const {
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  arguments.SetSslTargetNameOverride("localhost");
  return grpc::CreateCustomChannel(target_, credentials, arguments);
}

std::string ask(const std::shared_ptr<grpc::Channel>& channel,
                const std::vector<std::string>& authorization) {
  grpc::ClientContext context;
  context.set_wait_for_ready(true);
  for (const std::string& header : authorization) context.AddMetadata("authorization", header);
  v1::GetServerInfoResponse reply;
  const grpc::Status status =
      v1::ServerService::NewStub(channel)->GetServerInfo(&context, {}, &reply);
  return status.ok() ? reply.version() : reason_of(status);
}

}  // namespace sightline::tests
