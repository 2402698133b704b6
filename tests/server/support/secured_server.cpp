// A server with TLS and tokens, in this process, and channels to it.
#include "tests/server/support/secured_server.h"

#include <fmt/format.h>
#include <grpc/grpc.h>
#include <grpcpp/client_context.h>
#include <grpcpp/create_channel.h>
#include <openssl/crypto.h>
#include <spdlog/spdlog.h>

#include <chrono>

#include "tests/server/support/token_file.h"

namespace sightline::tests {
namespace {

/// Threads of gRPC live until the process ends. If OpenSSL cleaned up before, what it keeps for
/// each of them would be leaked.
const int kNeverCleanedUp = OPENSSL_init_crypto(OPENSSL_INIT_NO_ATEXIT, nullptr);

}  // namespace

SecuredServer::SecuredServer(bool mutual) {
  EXPECT_EQ(kNeverCleanedUp, 1);
  // Never released: see connect() of live_server.cpp.
  static const bool library_held = (grpc_init(), true);
  static_cast<void>(library_held);
  spdlog::set_level(spdlog::level::off);
  server::ServerConfig config;
  config.listen = "0.0.0.0:0";
  config.threads = 2;
  config.drain = std::chrono::milliseconds(50);
  write_certificate(authority_.issue());
  config.tls = {
      .certificate = dir_.path("server.pem"), .key = dir_.path("server.key"), .client_ca = {}};
  if (mutual) {
    config.tls.client_ca = dir_.write("clients.pem", client_authority_.certificate());
  } else {
    config.tokens = dir_.write("tokens.toml", tokens());
  }
  auto started = server::Server::start(config);
  EXPECT_TRUE(started) << started.error().message;
  server_ = *std::move(started);
}

std::string SecuredServer::tokens() {
  return token_row("reader", kReader, "read", R"("projects/site/")") +
         token_row("writer", kWriter, "write", R"("projects/site/")") +
         token_row("administrator", kAdministrator, "admin", R"("projects/site/")") +
         token_row("stranger", kStranger, "admin", R"("projects/other/")");
}

void SecuredServer::write_certificate(const TestCertificate& certificate) {
  dir_.write("server.key", certificate.key);
  dir_.write("server.pem", certificate.certificate);
}

std::shared_ptr<grpc::Channel> SecuredServer::connect(const ClientPems& pems,
                                                      const std::string& host) const {
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, 100);
  // The library that looks names up leaks them.
  arguments.SetSslTargetNameOverride(host);
  const std::string address = host == "localhost" ? "127.0.0.1" : host;
  const auto credentials = pems.authority.empty()
                               ? grpc::InsecureChannelCredentials()
                               : grpc::SslCredentials({pems.authority, pems.key, pems.certificate});
  return grpc::CreateCustomChannel(fmt::format("{}:{}", address, server_->port()), credentials,
                                   arguments);
}

std::shared_ptr<grpc::Channel> SecuredServer::connected(std::shared_ptr<grpc::Channel> channel) {
  // The limit only ends a failing test.
  EXPECT_TRUE(
      channel->WaitForConnected(std::chrono::system_clock::now() + std::chrono::minutes(1)));
  return channel;
}

grpc::Status SecuredServer::get(const std::shared_ptr<grpc::Channel>& channel,
                                const std::string& scene, const std::string& token) {
  grpc::ClientContext context;
  if (!token.empty()) context.AddMetadata("authorization", "Bearer " + token);
  v1::GetSceneRequest request;
  request.set_name(scene);
  v1::GetSceneResponse reply;
  return v1::SceneService::NewStub(channel)->GetScene(&context, request, &reply);
}

void print_row(const std::string& tried, const grpc::Status& status) {
  const std::string reason = reason_of(status);
  const std::string more = reason.empty() ? status.error_message().substr(0, 120) : reason;
  print_row(tried, fmt::format("{} {}", static_cast<int>(status.error_code()), more));
}

void print_row(const std::string& tried, const std::string& outcome) {
  fmt::print("| {} | {} |\n", tried, outcome);
}

}  // namespace sightline::tests
