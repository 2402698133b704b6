// Puts a FrameGuard between a socket and gRPC, without a copy.
#include "server/net/guarded_sockets.h"

#include <dlfcn.h>
#include <openssl/ssl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstdint>

#include "server/net/guarded_socket.h"

namespace sightline::server::net {
namespace {

using Shared = std::shared_ptr<GuardedSocket>;

struct Entry {
  Shared socket;
  bool tls;
};

/// More numbers than an acceptor's connections can have (connection_limit()).
constexpr std::size_t kNumbers = std::size_t{1} << 16;

/// Guarded sockets by number. gRPC does not close a socket that it reads or writes.
std::array<std::atomic<Entry*>, kNumbers> entries;

thread_local const Shared* made_for = nullptr;

Entry* entry_of(int socket) {
  const auto number = static_cast<std::size_t>(socket);
  return number < kNumbers ? entries[number].load(std::memory_order_acquire) : nullptr;
}

/// The function of this name that the program would have called without this file.
template <class Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

void free_shared(void*, void* shared, CRYPTO_EX_DATA*, int, long, void*) {
  delete static_cast<Shared*>(shared);
}

int ssl_index() {
  static const int kIndex = SSL_get_ex_new_index(0, nullptr, nullptr, nullptr, free_shared);
  return kIndex;
}

GuardedSocket* socket_of(const SSL* ssl) {
  const auto* shared = static_cast<const Shared*>(SSL_get_ex_data(ssl, ssl_index()));
  return shared != nullptr ? shared->get() : nullptr;
}

std::size_t size_of(ssize_t size) { return static_cast<std::size_t>(size); }

}  // namespace

bool guard_socket(int socket, const GuardSettings& settings) {
  if (static_cast<std::size_t>(socket) >= kNumbers) return false;
  auto entry = std::make_unique<Entry>(Entry{
      std::make_shared<GuardedSocket>(socket, settings.max_streams, settings.ended), settings.tls});
  delete entries[static_cast<std::size_t>(socket)].exchange(entry.release());
  return true;
}

TlsOf::TlsOf(int socket) {
  if (const Entry* entry = entry_of(socket); entry != nullptr && entry->tls)
    made_for = &entry->socket;
}

TlsOf::~TlsOf() { made_for = nullptr; }

}  // namespace sightline::server::net

// The functions that gRPC calls. Their names are the libraries'.
extern "C" {

using namespace sightline::server::net;  // NOLINT(google-build-using-namespace)

[[gnu::visibility("default")]] ssize_t recvmsg(int socket, msghdr* message, int flags) {
  static auto* const kReal = next<decltype(recvmsg)>("recvmsg");
  const Entry* entry = entry_of(socket);
  if (entry == nullptr || flags != 0) return kReal(socket, message, flags);
  const GuardedSocket::Buffers buffers(message->msg_iov, message->msg_iovlen);
  if (entry->tls) return entry->socket->is_over() ? 0 : kReal(socket, message, flags);
  if (const auto size = entry->socket->instead(buffers)) {
    message->msg_controllen = 0;
    return static_cast<ssize_t>(*size);
  }
  const ssize_t size = kReal(socket, message, flags);
  if (size <= 0) return size;
  return static_cast<ssize_t>(entry->socket->received(buffers, size_of(size)));
}

[[gnu::visibility("default")]] ssize_t sendmsg(int socket, const msghdr* message, int flags) {
  static auto* const kReal = next<decltype(sendmsg)>("sendmsg");
  const Entry* entry = entry_of(socket);
  if (entry == nullptr || entry->tls) return kReal(socket, message, flags);
  entry->socket->sending({message->msg_iov, message->msg_iovlen});
  const ssize_t size = kReal(socket, message, flags);
  entry->socket->sent(size);
  return size;
}

[[gnu::visibility("default")]] int close(int socket) {
  static auto* const kReal = next<decltype(close)>("close");
  if (entry_of(socket) != nullptr)
    delete entries[static_cast<std::size_t>(socket)].exchange(nullptr);
  return kReal(socket);
}

[[gnu::visibility("default")]] void SSL_set_accept_state(SSL* ssl) {
  static auto* const kReal = next<decltype(SSL_set_accept_state)>("SSL_set_accept_state");
  if (made_for != nullptr) SSL_set_ex_data(ssl, ssl_index(), new Shared(*made_for));
  kReal(ssl);
}

[[gnu::visibility("default")]] int SSL_read(SSL* ssl, void* buffer, int capacity) {
  static auto* const kReal = next<decltype(SSL_read)>("SSL_read");
  GuardedSocket* socket = socket_of(ssl);
  if (socket == nullptr || capacity <= 0) return kReal(ssl, buffer, capacity);
  const iovec all{buffer, static_cast<std::size_t>(capacity)};
  const auto instead = socket->instead({&all, 1});
  if (instead && *instead > 0) return static_cast<int>(*instead);
  int size = kReal(ssl, buffer, capacity);
  while (instead && size > 0) size = kReal(ssl, buffer, capacity);
  return size > 0 ? static_cast<int>(socket->received({&all, 1}, size_of(size))) : size;
}

[[gnu::visibility("default")]] int SSL_write(SSL* ssl, const void* buffer, int size) {
  static auto* const kReal = next<decltype(SSL_write)>("SSL_write");
  GuardedSocket* socket = socket_of(ssl);
  if (socket == nullptr || size <= 0) return kReal(ssl, buffer, size);
  const iovec all{const_cast<void*>(buffer), static_cast<std::size_t>(size)};
  socket->sending({&all, 1});
  const int written = kReal(ssl, buffer, size);
  socket->sent(written);
  return written;
}

}  // extern "C"
