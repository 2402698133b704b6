// Peers that do not do what a server of a shard does, for tests.
#pragma once

#include <grpcpp/grpcpp.h>
#include <grpcpp/health_check_service_interface.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <atomic>
#include <cstring>
#include <memory>
#include <string>

#include "sightline/v1/query.grpc.pb.h"

namespace sightline::tests {

/// Listens and says nothing, as a process that is stopped.
class MutePeer {
 public:
  explicit MutePeer(const std::string& path) : socket_(socket(AF_UNIX, SOCK_STREAM, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path.c_str(), sizeof(address.sun_path) - 1);
    EXPECT_EQ(bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
    EXPECT_EQ(listen(socket_, 8), 0);
  }
  MutePeer(const MutePeer&) = delete;
  MutePeer& operator=(const MutePeer&) = delete;
  ~MutePeer() { close(socket_); }

 private:
  const int socket_;
};

/// Answers pings, and no cast before it is cancelled.
class SlowPeer {
 public:
  explicit SlowPeer(const std::string& path) {
    grpc::EnableDefaultHealthCheckService(true);
    grpc::ServerBuilder builder;
    builder.AddListeningPort("unix:" + path, grpc::InsecureServerCredentials());
    builder.RegisterService(&service_);
    server_ = builder.BuildAndStart();
    EXPECT_NE(server_, nullptr);
  }
  SlowPeer(const SlowPeer&) = delete;
  SlowPeer& operator=(const SlowPeer&) = delete;
  ~SlowPeer() { server_->Shutdown(std::chrono::system_clock::now()); }

  int begun() const { return service_.begun; }          ///< casts and queries of points
  int cancelled() const { return service_.cancelled; }  ///< casts

 private:
  struct Service final : v1::RayQueryService::CallbackService {
    class Cast final : public grpc::ServerUnaryReactor {
     public:
      explicit Cast(Service& service) : service_(service) { ++service_.begun; }
      void OnCancel() override {
        ++service_.cancelled;
        Finish(grpc::Status::CANCELLED);
      }
      void OnDone() override { delete this; }

     private:
      Service& service_;
    };

    grpc::ServerUnaryReactor* CastRays(grpc::CallbackServerContext*, const v1::CastRaysRequest*,
                                       v1::CastRaysResponse*) override {
      return new Cast(*this);
    }
    grpc::ServerUnaryReactor* QueryPoints(grpc::CallbackServerContext*,
                                          const v1::QueryPointsRequest*,
                                          v1::QueryPointsResponse*) override {
      return new Cast(*this);
    }

    std::atomic<int> begun{0}, cancelled{0};
  };

  Service service_;
  std::unique_ptr<grpc::Server> server_;
};

}  // namespace sightline::tests
