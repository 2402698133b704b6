// The WebSocket of a live page, with its calls.
#pragma once

#include <boost/asio/steady_timer.hpp>
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

/// A socket lives until its peer is gone, which cancels its calls. A peer that breaks the rules of
/// sightline/page/v1/tunnel.proto is closed. What waits in it is bounded both ways: while its calls
/// cannot take more, or the page does not read, it is not read either, and its calls wait. Threads:
/// that of the server.
class WebSocket : public std::enable_shared_from_this<WebSocket> {
 public:
  using Request = boost::beast::http::request<boost::beast::http::empty_body>;

  /// `tunnel` outlives it. `peer`: in the form of exec::caller_of().
  static void start(Stream stream, Request request, Tunnel& tunnel, const std::string& peer);
  ~WebSocket();

 private:
  struct Call {
    std::shared_ptr<TunnelCall> call;
    std::size_t untaken = 0;
  };

  WebSocket(Stream stream, Request request, Tunnel& tunnel, const std::string& peer);

  void accept();
  void read_on();
  void read();
  bool is_behind() const;
  bool take(const page::v1::TunnelRequest& request);
  void open(const page::v1::TunnelRequest& request);
  void pass_on(Call& call, const page::v1::TunnelRequest& request);
  void taken(std::uint32_t call, std::size_t bytes);
  void deliver(std::uint32_t call, std::string message);
  void want_more();
  void end(std::uint32_t call, const grpc::Status& status);
  void send(const page::v1::TunnelResponse& response);
  void write();
  void restart_timer();
  void refuse();
  void give_up();
  void cancel_calls();

  boost::beast::websocket::stream<Stream> socket_;
  const Request request_;
  Tunnel& tunnel_;
  const std::string peer_;
  Tunnel::Position position_;
  boost::asio::steady_timer late_;
  boost::beast::flat_buffer buffer_;
  std::map<std::uint32_t, Call> calls_;
  std::size_t untaken_ = 0;         // bytes, of all calls
  std::deque<std::string> unsent_;  // the first is being written
  std::size_t unsent_bytes_ = 0;
  std::vector<std::uint32_t> waiting_;  // calls whose next message is not wanted yet
  bool paused_ = false;                 // not read, as it is behind
  bool ended_ = false;
};

}  // namespace sightline::server::admin
