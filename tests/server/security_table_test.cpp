// What strangers try, line by line; each line is printed with how it ended. The table:
// sightline_security_tests --gtest_filter='SecurityTable*' | grep '^|'.
#include <grpcpp/client_context.h>
#include <gtest/gtest.h>

#include <chrono>
#include <string>

#include "tests/server/support/raw_call.h"
#include "tests/server/support/secured_server.h"
#include "tests/server/support/tcp.h"
#include "tests/server/support/token_file.h"

namespace sightline::tests {
namespace {

using grpc::StatusCode;

class SecurityTable : public SecuredServer {
 protected:
  void expect(const std::string& tried, const grpc::Status& status, StatusCode code,
              const std::string& reason = {}) {
    print_row(tried, status);
    EXPECT_EQ(status.error_code(), code) << tried << ": " << status.error_message();
    EXPECT_EQ(reason_of(status), reason) << tried;
  }

  /// The server still answers, and right.
  void expect_alive() {
    EXPECT_EQ(reason_of(get(connect(), kOwnScene, kReader)), "SCENE_NOT_FOUND");
  }

  /// Calls until the end is as wanted: the server reads its files about once a second.
  template <class Call>
  grpc::Status call_until(const Call& call, const std::string& reason) {
    for (;;) {
      const grpc::Status status = call();
      if (reason_of(status) == reason) return status;
    }
  }
};

TEST_F(SecurityTable, PlaintextToATlsPort) {
  expect("plaintext gRPC to a TLS port", try_to_connect({}), StatusCode::UNAVAILABLE);
  const auto garbage = connect_tcp(server_->port());
  send_bytes(garbage, "GET / HTTP/1.1\r\n\r\n");
  while (!receive_bytes(garbage).empty()) {
  }
  print_row("plaintext HTTP/1.1 to a TLS port", std::string("closed"));
  expect_alive();
}

TEST_F(SecurityTable, CertificatesOfTheServerThatAClientMustNotTrust) {
  const TestAuthority other("Other CA");
  expect("a server of another CA", try_to_connect({other.certificate(), {}, {}}),
         StatusCode::UNAVAILABLE);
  expect("a server of another name",
         try_to_connect({authority_.certificate(), {}, {}}, "127.0.0.2"), StatusCode::UNAVAILABLE);
  expect("a server that is trusted", get(connect(), kOwnScene, kReader), StatusCode::NOT_FOUND,
         "SCENE_NOT_FOUND");
}

TEST_F(SecurityTable, AnExpiredCertificateAndItsReplacementWithoutARestart) {
  const auto before = connect();
  ASSERT_EQ(reason_of(get(before, kOwnScene, kReader)), "SCENE_NOT_FOUND");
  write_certificate(authority_.issue({.valid_for = std::chrono::seconds(-60)}));
  grpc::Status expired;
  while (expired.error_code() != StatusCode::UNAVAILABLE)
    expired = try_to_connect({authority_.certificate(), {}, {}});
  expect("an expired certificate, loaded while the server runs", expired, StatusCode::UNAVAILABLE);
  expect("a connection from before", get(before, kOwnScene, kReader), StatusCode::NOT_FOUND,
         "SCENE_NOT_FOUND");
  write_certificate(authority_.issue());
  expect("its replacement",
         call_until(
             [&] {
               return try_to_connect({authority_.certificate(), {}, {}});
             },
             "SCENE_NOT_FOUND"),
         StatusCode::NOT_FOUND, "SCENE_NOT_FOUND");
}

TEST_F(SecurityTable, CertificateFilesThatDoNotFitKeepTheOldOnes) {
  const TestAuthority other("Other CA");
  dir_.write("server.key", other.issue().key);
  dir_.write("server.pem", "no certificate");
  // A token that is new tells that the server has read its files again.
  dir_.write("tokens.toml", tokens() + token_row("late", "late-token", "read", R"("")"));
  expect("a broken certificate and another one's key: the old ones stay",
         call_until([&] { return get(connect(), kOwnScene, "late-token"); }, "SCENE_NOT_FOUND"),
         StatusCode::NOT_FOUND, "SCENE_NOT_FOUND");
}

TEST_F(SecurityTable, TokensThatAreMissingOrUnknown) {
  const auto channel = connect();
  expect("no token", get(channel, kOwnScene, {}), StatusCode::UNAUTHENTICATED, "TOKEN_MISSING");
  expect("an unknown token", get(channel, kOwnScene, "guess"), StatusCode::UNAUTHENTICATED,
         "TOKEN_UNKNOWN");
  expect("the hash of a token", get(channel, kOwnScene, hash_of(kReader)),
         StatusCode::UNAUTHENTICATED, "TOKEN_UNKNOWN");
  expect("a token of 7 KiB", get(channel, kOwnScene, std::string(7 << 10, 'x')),
         StatusCode::UNAUTHENTICATED, "TOKEN_UNKNOWN");
  grpc::ClientContext twice;
  twice.AddMetadata("authorization", "Bearer " + kReader);
  twice.AddMetadata("authorization", "Bearer guess");
  v1::GetServerInfoResponse info;
  expect("two tokens", v1::ServerService::NewStub(channel)->GetServerInfo(&twice, {}, &info),
         StatusCode::UNAUTHENTICATED, "TOKEN_MISSING");
}

TEST_F(SecurityTable, RolesAndPrefixes) {
  v1::ApplyUpdatesRequest update;
  update.set_scene(kOwnScene);
  const std::string apply = "/sightline.v1.SceneService/ApplyUpdates";
  const auto channel = connect();
  expect("a read token that writes", call_raw(channel, apply, update.SerializeAsString(), kReader),
         StatusCode::PERMISSION_DENIED, "ROLE_MISSING");
  expect("a token of another prefix", get(channel, kOwnScene, kStranger),
         StatusCode::PERMISSION_DENIED, "SCENE_FORBIDDEN");
  expect("... for a scene that does not exist",
         get(channel, "projects/site/scenes/none", kStranger), StatusCode::PERMISSION_DENIED,
         "SCENE_FORBIDDEN");
  expect("a prefix with `..`",
         get(channel, "projects/other/scenes/../../site/scenes/own", kStranger),
         StatusCode::INVALID_ARGUMENT, "BAD_RESOURCE_NAME");
}

TEST_F(SecurityTable, TokensAreReloaded) {
  const auto channel = connect();
  dir_.write("tokens.toml", tokens() + token_row("late", "late-token", "read", R"("")"));
  const auto late = [&] { return get(channel, kOwnScene, "late-token"); };
  expect("a token that was added", call_until(late, "SCENE_NOT_FOUND"), StatusCode::NOT_FOUND,
         "SCENE_NOT_FOUND");

  grpc::ClientContext open;
  open.AddMetadata("authorization", "Bearer late-token");
  const auto stub = v1::RayQueryService::NewStub(channel);
  const auto stream = stub->StreamCastRays(&open);
  ASSERT_EQ(reason_of(late()), "SCENE_NOT_FOUND") << "the stream, which was before it, has come";
  dir_.write("tokens.toml", tokens());
  expect("a token that was removed", call_until(late, "TOKEN_UNKNOWN"), StatusCode::UNAUTHENTICATED,
         "TOKEN_UNKNOWN");
  v1::StreamCastRaysResponse reply;
  EXPECT_FALSE(stream->Read(&reply));
  expect("... and its open stream", stream->Finish(), StatusCode::UNAUTHENTICATED);

  // The certificate that is new tells that the server has read its files again.
  dir_.write("tokens.toml", "[[token]]\nname = ");
  write_certificate(authority_.issue({.name = "127.0.0.2", .alternatives = "IP:127.0.0.2"}));
  while (try_to_connect({authority_.certificate(), {}, {}}, "127.0.0.2").error_code() !=
         StatusCode::NOT_FOUND) {
  }
  expect("a broken file of tokens: the old ones stay", get(channel, kOwnScene, kReader),
         StatusCode::NOT_FOUND, "SCENE_NOT_FOUND");
}

TEST_F(SecurityTable, NamesThatAreNoNames) {
  const auto channel = connect();
  for (const std::string name :
       {"../../etc/passwd", "projects/site/scenes/../../../etc/passwd", "projects/site/scenes/..",
        "projects/site/scenes/a%2f..%2fb", "projects/site/scenes/a\\..\\b",
        "projects/site/scenes/.", "/etc/passwd", ""}) {
    const grpc::Status status = get(channel, name, kReader);
    print_row("a scene named \"" + name + "\"", status);
    const bool refused = status.error_code() == StatusCode::INVALID_ARGUMENT ||
                         status.error_code() == StatusCode::PERMISSION_DENIED;
    EXPECT_TRUE(refused) << name;
  }
  expect("a name of 10 KiB",
         get(channel, "projects/site/scenes/" + std::string(10 << 10, 'a'), kReader),
         StatusCode::INVALID_ARGUMENT, "BAD_RESOURCE_NAME");
  v1::GetUploadStatusRequest status;
  status.set_digest("../../etc/passwd");
  expect("a mesh named \"../../etc/passwd\"",
         call_raw(channel, "/sightline.v1.BlobService/GetUploadStatus", status.SerializeAsString(),
                  kWriter),
         StatusCode::INVALID_ARGUMENT, "BAD_DIGEST");
}

TEST_F(SecurityTable, SizeBombs) {
  const auto channel = connect();
  const std::string cast = "/sightline.v1.RayQueryService/CastRays";
  v1::CastRaysRequest request;
  request.set_scene(kOwnScene);
  request.mutable_rays()->set_origins(std::string(std::size_t{5} << 20, '\0'));
  expect("a message of 5 MiB", call_raw(channel, cast, request.SerializeAsString(), kReader),
         StatusCode::RESOURCE_EXHAUSTED);
  request.mutable_rays()->set_origins(std::string(std::size_t{64} << 20, '\0'));
  expect("64 MiB in 64 KiB, by gzip",
         call_raw(channel, cast, request.SerializeAsString(), kReader, true),
         StatusCode::UNIMPLEMENTED);
  expect_alive();
}

TEST_F(SecurityTable, SlowLoris) {
  // Each begins and does not go on. The server closes them, and serves others meanwhile.
  const auto silent = connect_tcp(server_->port());
  const auto half_hello = connect_tcp(server_->port());
  send_bytes(half_hello, std::string("\x16\x03\x01\x02\x00\x01\x00\x01", 8));
  expect_alive();
  EXPECT_TRUE(receive_bytes(silent).empty());
  EXPECT_TRUE(receive_bytes(half_hello).empty());
  print_row("a connection that says nothing", std::string("closed"));
  print_row("half of a TLS greeting", std::string("closed"));
}

/// `depth` groups of field 1, one in another: an unknown field of every message.
std::string nested_groups(std::size_t depth) {
  return std::string(depth, '\x7b') + std::string(depth, '\x7c');  // field 15: start, end
}

TEST_F(SecurityTable, DeepNesting) {
  const auto channel = connect();
  v1::GetSceneRequest request;
  request.set_name(kOwnScene);
  const std::string get_scene = "/sightline.v1.SceneService/GetScene";
  expect("unknown fields nested 64 deep",
         call_raw(channel, get_scene, request.SerializeAsString() + nested_groups(64), kReader),
         StatusCode::NOT_FOUND, "SCENE_NOT_FOUND");
  expect(
      "unknown fields nested a million deep",
      call_raw(channel, get_scene, request.SerializeAsString() + nested_groups(1'000'000), kReader),
      StatusCode::INVALID_ARGUMENT, "MALFORMED_MESSAGE");
  expect_alive();
}

class SecurityTableMutual : public SecuredServer {
 protected:
  SecurityTableMutual() : SecuredServer(true) {}
  ClientPems pems(const TestCertificate& own) const {
    return {authority_.certificate(), own.certificate, own.key};
  }
  grpc::Status call_with(const TestCertificate& own) { return try_to_connect(pems(own)); }
};

TEST_F(SecurityTableMutual, OnlyClientsOfTheAuthority) {
  const TestAuthority other("Other CA");
  const auto row = [](const std::string& tried, const grpc::Status& status, StatusCode code) {
    print_row("mutual TLS: " + tried, status);
    EXPECT_EQ(status.error_code(), code) << tried << status.error_message();
  };
  row("no client certificate", call_with({}), StatusCode::UNAVAILABLE);
  row("one of another CA", call_with(other.issue({.name = "robot"})), StatusCode::UNAVAILABLE);
  row("an expired one",
      call_with(client_authority_.issue({.name = "robot", .valid_for = std::chrono::seconds(-60)})),
      StatusCode::UNAVAILABLE);
  const auto good = connected(connect(pems(client_authority_.issue({.name = "robot"}))));
  row("a good one", get(good, kOwnScene, {}), StatusCode::NOT_FOUND);
}

}  // namespace
}  // namespace sightline::tests
