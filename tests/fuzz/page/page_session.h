// A fuzzer's input as what a page sends through its WebSocket.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace sightline::tests {

struct PageStep {
  enum Kind : std::uint8_t {
    kMessage,  ///< The bytes as a message of sightline/page/v1/tunnel.proto.
    kFrame,    ///< The first byte begins a frame, the others are its content, masked.
    kRaw,      ///< The bytes as they are, in the middle of the stream.
    kRead,     ///< What the server has sent so far is read.
    kKinds,
  };
  Kind kind = kMessage;
  std::string bytes;
};

/// Takes any bytes. Lengths beyond the end are cut.
std::vector<PageStep> decode_page(std::span<const std::uint8_t> bytes);
std::vector<std::uint8_t> encode_page(const std::vector<PageStep>& steps);

/// Pages as they are meant to be, and the mistakes that were found.
std::vector<std::vector<PageStep>> example_pages();

}  // namespace sightline::tests
