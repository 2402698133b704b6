// Who calls: by a bearer token, or by the certificate of the client.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>

#include "proto/result.h"
#include "server/exec/call_context.h"
#include "server/security/tokens.h"

namespace sightline::server::security {

/// Bytes of a file of tokens.
inline constexpr std::size_t kMaxTokenFile = std::size_t{4} << 20;

/// Threads: any, for every member.
class Authenticator {
 public:
  /// `token_file`: empty for none. `client_certificates`: every connection has one that was
  /// verified. Without tokens its subject is the principal, and may do everything; with tokens it
  /// is needed beside the token. With neither, calls have no principal. Errors: kInvalidArgument or
  /// kFailedPrecondition, naming the file.
  static Result<std::unique_ptr<Authenticator>> make(const std::filesystem::path& token_file,
                                                     bool client_certificates);

  /// Sets the principal of a call. Errors: kUnauthenticated, reason TOKEN_MISSING or TOKEN_UNKNOWN.
  Status authenticate(exec::CallContext& context);

  /// Reads the file of tokens again if it has changed, and ends the open calls of tokens that are
  /// gone or may do something else now. A file that cannot be used changes nothing, and is logged
  /// once. Errors: as make().
  Status reload();

  /// Whether calls need tokens.
  bool has_tokens() const { return !token_file_.empty(); }

  /// The open calls. It makes the contexts of all calls of the server (make_contexts()).
  exec::CallContexts& calls() { return calls_; }

  /// Calls refused so far because it is not known who calls.
  std::uint64_t refused() const;

 private:
  Authenticator(std::filesystem::path token_file, bool client_certificates)
      : token_file_(std::move(token_file)), client_certificates_(client_certificates) {}

  Result<std::shared_ptr<const exec::Principal>> find(exec::CallContext& context) const;
  Result<std::shared_ptr<const exec::Principal>> of_token(const exec::CallContext& context) const;
  std::shared_ptr<const exec::Principal> of_certificate(exec::CallContext& context) const;
  std::shared_ptr<const Tokens> tokens() const;
  Status read_tokens();

  const std::filesystem::path token_file_;
  const bool client_certificates_;
  exec::CallContexts calls_;
  std::string content_, complained_;  // the file's; used by reload() alone
  mutable std::mutex mutex_;
  std::shared_ptr<const Tokens> tokens_;
  std::uint64_t refused_ = 0, refused_logged_ = 0;
};

}  // namespace sightline::server::security
