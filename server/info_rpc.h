// ServerService: what the server is, what it can do, and its limits.
#pragma once

#include <cstddef>

#include "server/config.h"
#include "server/exec/memory_account.h"
#include "server/segments/segments.h"
#include "sightline/v1/server.grpc.pb.h"

namespace sightline::server {

class InfoRpc : public v1::ServerService::CallbackService {
 public:
  /// `max_connections`: how many may be open at a time. `memory` and `segments` outlive this
  /// object.
  InfoRpc(const ServerConfig& config, std::size_t max_connections,
          const exec::MemoryAccount& memory, const segments::Segments& segments);

  grpc::ServerUnaryReactor* GetServerInfo(grpc::CallbackServerContext* context,
                                          const v1::GetServerInfoRequest* request,
                                          v1::GetServerInfoResponse* reply) override;
  grpc::ServerUnaryReactor* ReadLog(grpc::CallbackServerContext* context,
                                    const v1::ReadLogRequest* request,
                                    v1::ReadLogResponse* reply) override;

 private:
  const v1::GetServerInfoResponse info_;  // what is constant while the server runs
  const exec::MemoryAccount& memory_;
  const segments::Segments& segments_;
};

}  // namespace sightline::server
