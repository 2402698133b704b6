// Messages between a confined process and the one that started it. Files travel with them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <type_traits>

#include "client/importer/sandbox/file_handle.h"

namespace sightline::client::importer::sandbox {

/// A message from the confined process.
struct Request {
  enum class Kind : std::uint8_t {
    kOpen,         ///< `text` names a file; answered by a Reply
    kProgress,     ///< `part` is done
    kUnconfined,   ///< the system cannot confine it: `text` says why
    kOutOfMemory,  ///< and ends
    kDone,         ///< `bytes` of the result are written
  };
  Kind kind = Kind::kOpen;
  std::uint16_t length = 0;
  std::array<char, 1024> text{};
  double part = 0;
  std::uint64_t bytes = 0;

  static Request of(Kind kind, std::string_view text = {});
  /// What the sender wrote, at most as long as `text`.
  std::string_view message() const;
};

/// A message to the confined process. A file that was opened comes with it.
struct Reply {
  std::uint64_t bytes = 0;   ///< size of the file
  std::uint64_t number = 0;  ///< the file's number, whatever its name
};

struct Channel {
  FileHandle ours, theirs;
};

/// Opens a channel. Nothing: there are no more file descriptors.
std::optional<Channel> open_channel();

/// Returns false if the other side is gone.
bool send_bytes(int socket, const void* message, std::size_t size, int file = -1);
bool receive_bytes(int socket, void* message, std::size_t size, FileHandle* file = nullptr);

template <class Message>
bool send(int socket, const Message& message, int file = -1) {
  static_assert(std::is_trivially_copyable_v<Message>);
  return send_bytes(socket, &message, sizeof(message), file);
}

template <class Message>
bool receive(int socket, Message& message, FileHandle* file = nullptr) {
  static_assert(std::is_trivially_copyable_v<Message>);
  return receive_bytes(socket, &message, sizeof(message), file);
}

}  // namespace sightline::client::importer::sandbox
