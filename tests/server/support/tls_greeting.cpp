// A TLS handshake by OpenSSL itself, which shows what gRPC's clients do not.
#include "tests/server/support/tls_greeting.h"

#include <gtest/gtest.h>
#include <openssl/bio.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/ssl.h>

#include <memory>

#include "tests/server/support/tcp.h"

namespace sightline::tests {
namespace {

struct FreeTls {
  void operator()(SSL_CTX* context) const { SSL_CTX_free(context); }
  void operator()(SSL* connection) const { SSL_free(connection); }
  void operator()(X509* certificate) const { X509_free(certificate); }
  void operator()(BIO* bio) const { BIO_free(bio); }
};
template <class T>
using Owned = std::unique_ptr<T, FreeTls>;

/// OpenSSL asks for the client's certificate only if the server did.
int note_request(SSL* connection, X509**, EVP_PKEY**) {
  static_cast<TlsGreeting*>(SSL_get_app_data(connection))->asked = true;
  return 0;
}

/// Offers one version, also one that OpenSSL's defaults leave out.
Owned<SSL_CTX> offer(int version) {
  Owned<SSL_CTX> context(SSL_CTX_new(TLS_client_method()));
  SSL_CTX_set_cipher_list(context.get(), "DEFAULT:@SECLEVEL=0");
  EXPECT_EQ(SSL_CTX_set_min_proto_version(context.get(), version), 1);
  EXPECT_EQ(SSL_CTX_set_max_proto_version(context.get(), version), 1);
  constexpr unsigned char kHttp2[] = {2, 'h', '2'};
  SSL_CTX_set_alpn_protos(context.get(), kHttp2, sizeof kHttp2);
  SSL_CTX_set_client_cert_cb(context.get(), note_request);
  return context;
}

std::string pem_of_peer(const SSL* connection) {
  const Owned<X509> peer(SSL_get1_peer_certificate(connection));
  if (peer == nullptr) return {};
  const Owned<BIO> bio(BIO_new(BIO_s_mem()));
  PEM_write_bio_X509(bio.get(), peer.get());
  char* data = nullptr;
  const long size = BIO_get_mem_data(bio.get(), &data);
  return {data, static_cast<std::size_t>(size)};
}

/// gRPC's server sends no alert when it refuses.
bool hung_up(int error) {
  if (error == SSL_ERROR_SYSCALL) return true;
  return error == SSL_ERROR_SSL &&
         ERR_GET_REASON(ERR_peek_error()) == SSL_R_UNEXPECTED_EOF_WHILE_READING;
}

}  // namespace

TlsGreeting greet_by_tls(int port, int version) {
  TlsGreeting greeting;
  const Owned<SSL_CTX> context = offer(version);
  const Owned<SSL> connection(SSL_new(context.get()));
  SSL_set_app_data(connection.get(), &greeting);
  const auto socket = connect_tcp(port);
  SSL_set_fd(connection.get(), socket.number());
  ERR_clear_error();
  const int connected = SSL_connect(connection.get());
  greeting.done = connected == 1;
  greeting.hung_up = hung_up(SSL_get_error(connection.get(), connected));
  greeting.certificate = pem_of_peer(connection.get());
  ERR_clear_error();
  return greeting;
}

}  // namespace sightline::tests
