// A server with TLS and tokens, in this process, and channels to it.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "server/server.h"
#include "tests/client/support/temp_dir.h"
#include "tests/server/support/api.h"
#include "tests/support/certificates.h"

namespace sightline::tests {

inline const std::string kReader = "reader-token", kWriter = "writer-token",
                         kAdministrator = "administrator-token", kStranger = "stranger-token";
inline const std::string kOwnScene = "projects/site/scenes/own";
inline const std::string kOtherScene = "projects/other/scenes/other";

/// Of which authority and with which certificate a client connects. PEM; empty: none.
struct ClientPems {
  std::string authority, certificate, key;
};

class SecuredServer : public testing::Test {
 protected:
  /// `mutual`: clients need a certificate of client_authority_.
  explicit SecuredServer(bool mutual = false);

  /// Reader, writer and administrator of projects/site, and an administrator of projects/other.
  static std::string tokens();
  /// Replaces the server's certificate and key.
  void write_certificate(const TestCertificate& certificate);

  /// A connection of its own to `host`; no TLS without an authority.
  std::shared_ptr<grpc::Channel> connect(const ClientPems& pems,
                                         const std::string& host = "localhost") const;
  /// The channel, once its connection stands.
  static std::shared_ptr<grpc::Channel> connected(std::shared_ptr<grpc::Channel> channel);
  /// As a client that trusts the server's authority.
  std::shared_ptr<grpc::Channel> connect() const {
    return connected(connect({authority_.certificate(), {}, {}}));
  }

  /// GetScene of this name.
  static grpc::Status get(const std::shared_ptr<grpc::Channel>& channel, const std::string& scene,
                          const std::string& token);
  /// The same on a new connection, whether it comes about or not.
  grpc::Status try_to_connect(const ClientPems& pems, const std::string& host = "localhost") const {
    return get(connect(pems, host), kOwnScene, kReader);
  }

  TempDir dir_;
  const TestAuthority authority_, client_authority_{"Client CA"};
  std::unique_ptr<server::Server> server_;
};

/// Prints a line of the table of attacks: what was tried, and how it ended.
void print_row(const std::string& tried, const grpc::Status& status);
void print_row(const std::string& tried, const std::string& outcome);

}  // namespace sightline::tests
