// What a channel proves and what it asks for: TLS, and the token that goes with each call.
#include "client/calls/channel_credentials.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <utility>

#include "proto/printable.h"

namespace sightline::client::calls {
namespace {

namespace experimental = grpc::experimental;

/// The content of the file; empty without one.
Result<std::string> read_pem(const std::filesystem::path& file) {
  if (file.empty()) return std::string();
  std::ifstream in(file, std::ios::binary);
  std::string content(std::istreambuf_iterator<char>(in), {});
  if (in && !content.empty()) return content;
  return Error{
      Code::kInvalidArgument, fmt::format("cannot read {}, or it is empty", file.string()), {}};
}

Result<std::shared_ptr<grpc::ChannelCredentials>> channel_credentials(
    const ClientOptions& options) {
  if (options.tls_ca.empty()) {
    if (options.tls_cert.empty() && options.tls_key.empty())
      return grpc::InsecureChannelCredentials();
    return Error{Code::kInvalidArgument,
                 "a certificate of the client needs TLS: name the authority of the server, too",
                 {}};
  }
  if (options.tls_cert.empty() != options.tls_key.empty())
    return Error{
        Code::kInvalidArgument, "a certificate needs its key, and a key its certificate", {}};
  const auto authority = read_pem(options.tls_ca);
  if (!authority) return authority.error();
  const auto certificate = read_pem(options.tls_cert);
  if (!certificate) return certificate.error();
  const auto key = read_pem(options.tls_key);
  if (!key) return key.error();
  return grpc::SslCredentials({*authority, *key, *certificate});
}

class TokenSender final : public experimental::Interceptor {
 public:
  explicit TokenSender(const std::string& header) : header_(header) {}
  void Intercept(experimental::InterceptorBatchMethods* batch) override {
    if (batch->QueryInterceptionHookPoint(
            experimental::InterceptionHookPoints::PRE_SEND_INITIAL_METADATA))
      batch->GetSendInitialMetadata()->emplace("authorization", header_);
    batch->Proceed();
  }

 private:
  const std::string& header_;
};

class TokenSenders final : public experimental::ClientInterceptorFactoryInterface {
 public:
  explicit TokenSenders(const std::string& token) : header_("Bearer " + token) {}
  experimental::Interceptor* CreateClientInterceptor(experimental::ClientRpcInfo*) override {
    return new TokenSender(header_);
  }

 private:
  const std::string header_;
};

}  // namespace

Result<ChannelCredentials> ChannelCredentials::make(const Endpoint& endpoint,
                                                    const ClientOptions& options) {
  auto channel = channel_credentials(options);
  if (!channel) return channel.error();
  const std::string& token = options.token;
  if (!token.empty() && !is_visible(token))
    return Error{Code::kInvalidArgument, "the token has characters other than visible ASCII", {}};
  if (!token.empty() && options.tls_ca.empty() && !endpoint.is_local()) {
    return Error{Code::kUnauthenticated,
                 fmt::format("the token is not sent to {} without encryption: use TLS (--tls-ca)",
                             endpoint.text()),
                 "TOKEN_IN_PLAINTEXT"};
  }
  return ChannelCredentials{*std::move(channel), token};
}

std::vector<std::unique_ptr<experimental::ClientInterceptorFactoryInterface>> send_token(
    const std::string& token) {
  std::vector<std::unique_ptr<experimental::ClientInterceptorFactoryInterface>> interceptors;
  if (!token.empty()) interceptors.push_back(std::make_unique<TokenSenders>(token));
  return interceptors;
}

bool tells_of_tls(const std::string& message) {
  return message.find("handshake failed") != std::string::npos ||
         message.find("not in peer certificate") != std::string::npos;
}

}  // namespace sightline::client::calls
