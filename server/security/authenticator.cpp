// Who calls: by a bearer token, or by the certificate of the client.
#include "server/security/authenticator.h"

#include <fmt/format.h>
#include <grpcpp/security/auth_context.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "server/exec/rpc_status.h"
#include "server/security/read_file.h"

namespace sightline::server::security {
namespace {

using PrincipalPointer = std::shared_ptr<const exec::Principal>;

/// The token of the only authorization header, which is "Bearer TOKEN". The scheme's case does not
/// matter (RFC 9110).
std::optional<std::string_view> bearer_token(const exec::CallContext& context) {
  constexpr std::string_view kScheme = "bearer ";
  const auto [first, last] = context.client_metadata().equal_range("authorization");
  if (first == last || std::next(first) != last) return {};
  const std::string_view value(first->second.data(), first->second.size());
  const auto equal = [](char letter, char c) { return letter == (c | 0x20); };
  if (value.size() <= kScheme.size() ||
      !std::equal(kScheme.begin(), kScheme.end(), value.begin(), equal))
    return {};
  return value.substr(kScheme.size());
}

}  // namespace

Result<std::unique_ptr<Authenticator>> Authenticator::make(const std::filesystem::path& token_file,
                                                           bool client_certificates) {
  std::unique_ptr<Authenticator> made(new Authenticator(token_file, client_certificates));
  if (const Status read = made->read_tokens(); !read) return read.error();
  return made;
}

Status Authenticator::read_tokens() {
  if (token_file_.empty()) return {};
  auto content = read_file(token_file_, kMaxTokenFile);
  if (!content) return content.error();
  if (*content == content_) return {};
  auto parsed = Tokens::parse(*content);
  if (!parsed) {
    Error error = parsed.error();
    error.message = fmt::format("{}, {}", token_file_.string(), error.message);
    return error;
  }
  if (const auto old = tokens()) parsed->keep_equal(*old);
  content_ = *std::move(content);
  spdlog::info("event=tokens_loaded file={} tokens={}", exec::quote(token_file_.string()),
               parsed->size());
  const std::lock_guard lock(mutex_);
  tokens_ = std::make_shared<const Tokens>(*std::move(parsed));
  return {};
}

Status Authenticator::reload() {
  const auto before = tokens();
  Status read = read_tokens();
  std::string complaint = read ? std::string() : read.error().message;
  if (!complaint.empty() && complaint != complained_)
    spdlog::error("event=tokens_not_loaded kept=old error={}", exec::quote(complaint));
  complained_ = std::move(complaint);
  if (tokens() != before) {
    calls_.end_outdated([this](exec::CallContext& context) {
      const auto found = of_token(context);
      return found ? *found : nullptr;
    });
  }
  const std::lock_guard lock(mutex_);
  if (refused_ == refused_logged_) return read;
  spdlog::warn("event=unauthenticated calls={}", refused_ - refused_logged_);
  refused_logged_ = refused_;
  return read;
}

Status Authenticator::authenticate(exec::CallContext& context) {
  for (auto used = tokens();; used = tokens()) {
    auto principal = find(context);
    if (!principal) {
      const std::lock_guard lock(mutex_);
      ++refused_;
      return principal.error();
    }
    context.set_principal(*std::move(principal));
    // Tokens that were replaced before the call was among the open ones may lack this one.
    if (tokens() == used) return {};
  }
}

std::uint64_t Authenticator::refused() const {
  const std::lock_guard lock(mutex_);
  return refused_;
}

Result<PrincipalPointer> Authenticator::find(exec::CallContext& context) const {
  if (!token_file_.empty()) return of_token(context);
  return client_certificates_ ? of_certificate(context) : nullptr;
}

Result<PrincipalPointer> Authenticator::of_token(const exec::CallContext& context) const {
  const auto token = bearer_token(context);
  if (!token) {
    return Error{Code::kUnauthenticated,
                 "the call needs one header \"authorization: Bearer TOKEN\"", "TOKEN_MISSING"};
  }
  auto principal = tokens()->find(*token);
  if (principal == nullptr)
    return Error{Code::kUnauthenticated, "the token is not known here", "TOKEN_UNKNOWN"};
  return principal;
}

PrincipalPointer Authenticator::of_certificate(exec::CallContext& context) const {
  std::string name;
  for (const grpc::string_ref& part : context.auth_context()->FindPropertyValues("x509_subject"))
    name.assign(part.data(), part.size());
  return std::make_shared<const exec::Principal>(exec::Principal{
      .name = std::move(name), .grants = {{.role = exec::Role::kAdmin, .prefixes = {""}}}});
}

std::shared_ptr<const Tokens> Authenticator::tokens() const {
  const std::lock_guard lock(mutex_);
  return tokens_;
}

}  // namespace sightline::server::security
