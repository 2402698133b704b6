// The socket of a live page, as its server sees it.
#pragma once

#include <google/protobuf/message.h>
#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "sightline/page/v1/tunnel.pb.h"

namespace sightline::tests {

/// A page's socket.
class Page {
 public:
  /// Connects from this address of this machine.
  explicit Page(int port, const std::string& from = "127.0.0.1") {
    using boost::asio::ip::make_address;
    boost::asio::ip::tcp::socket& socket = socket_.next_layer();
    socket.open(boost::asio::ip::tcp::v4());
    socket.bind({make_address(from), 0});
    socket.connect({make_address("127.0.0.1"), static_cast<std::uint16_t>(port)});
  }

  /// Returns whether the server opened the socket.
  bool open(const std::string& origin = {}, const std::string& host = "127.0.0.1") {
    socket_.set_option(boost::beast::websocket::stream_base::decorator(
        [&](boost::beast::websocket::request_type& request) {
          if (!origin.empty()) request.set(boost::beast::http::field::origin, origin);
        }));
    boost::system::error_code error;
    socket_.handshake(host, "/", error);
    socket_.binary(true);
    EXPECT_TRUE(!error || error == boost::beast::websocket::error::upgrade_declined)
        << error.message();
    return !error;
  }

  void send(const page::v1::TunnelRequest& request) {
    socket_.write(boost::asio::buffer(request.SerializeAsString()));
  }
  /// Sends the request again and again, until the socket is closed or this many bytes are sent,
  /// which it returns. Reads nothing.
  std::size_t flood(const page::v1::TunnelRequest& request, std::size_t most) {
    const std::string bytes = request.SerializeAsString();
    boost::system::error_code error;
    std::size_t sent = 0;
    while (sent < most && !error) sent += socket_.write(boost::asio::buffer(bytes), error);
    return sent;
  }
  void call(std::uint32_t number, const std::string& method,
            const google::protobuf::Message& message, const std::string& authorization = {}) {
    page::v1::TunnelRequest request;
    request.set_call(number);
    request.set_method("/sightline.v1." + method);
    request.set_authorization(authorization);
    request.set_message(message.SerializeAsString());
    request.set_last(true);
    send(request);
  }

  /// A stream of rays that stays open.
  void open_stream(std::uint32_t number) {
    page::v1::TunnelRequest request;
    request.set_call(number);
    request.set_method("/sightline.v1.RayQueryService/StreamCastRays");
    send(request);
  }

  /// Nothing: the socket was closed.
  std::optional<page::v1::TunnelResponse> receive() {
    boost::beast::flat_buffer buffer;
    boost::system::error_code error;
    socket_.read(buffer, error);
    page::v1::TunnelResponse response;
    if (error || !response.ParseFromArray(buffer.data().data(), static_cast<int>(buffer.size())))
      return {};
    return response;
  }
  /// The code with which the next call ends, messages before it left out.
  int end() {
    for (;;) {
      const auto response = receive();
      if (!response) return -1;
      if (response->has_end()) return static_cast<int>(response->end().code());
    }
  }

 private:
  boost::asio::io_context context_;
  boost::beast::websocket::stream<boost::asio::ip::tcp::socket> socket_{context_};
};

}  // namespace sightline::tests
