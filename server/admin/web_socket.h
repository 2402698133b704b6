// The WebSocket of a live page, with its calls.
#pragma once

#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "server/admin/http_session.h"
#include "server/admin/tunnel.h"
#include "server/admin/tunnel_call.h"
#include "sightline/page/v1/tunnel.pb.h"

namespace sightline::server::admin {

/// Lives until its peer is gone, which cancels its calls. A peer that breaks the rules of
/// sightline/page/v1/tunnel.proto is closed. Threads: that of the server.
class WebSocket : public std::enable_shared_from_this<WebSocket> {
 public:
  using Request = boost::beast::http::request<boost::beast::http::empty_body>;

  /// `tunnel` outlives it.
  static void start(Stream stream, Request request, Tunnel& tunnel);
  ~WebSocket();

 private:
  WebSocket(Stream stream, Request request, Tunnel& tunnel);

  void accept();
  void read();
  bool take(const page::v1::TunnelRequest& request);
  void open(const page::v1::TunnelRequest& request);
  void deliver(std::uint32_t call, std::string message);
  void want_more();
  void end(std::uint32_t call, const grpc::Status& status);
  void send(const page::v1::TunnelResponse& response);
  void write();

  boost::beast::websocket::stream<Stream> socket_;
  const Request request_;
  Tunnel& tunnel_;
  boost::beast::flat_buffer buffer_;
  std::map<std::uint32_t, std::shared_ptr<TunnelCall>> calls_;
  std::deque<std::string> unsent_;  // the first is being written
  std::size_t unsent_bytes_ = 0;
  std::vector<std::uint32_t> waiting_;  // calls whose next message is not wanted yet
};

}  // namespace sightline::server::admin
