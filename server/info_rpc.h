// ServerService: what the server is, what it can do, and its limits.
#pragma once

#include "server/config.h"
#include "sightline/v1/server.grpc.pb.h"

namespace sightline::server {

class InfoRpc final : public v1::ServerService::CallbackService {
 public:
  explicit InfoRpc(const ServerConfig& config);

  grpc::ServerUnaryReactor* GetServerInfo(grpc::CallbackServerContext* context,
                                          const v1::GetServerInfoRequest* request,
                                          v1::GetServerInfoResponse* reply) override;

 private:
  const v1::GetServerInfoResponse info_;  // constant while the server runs
};

}  // namespace sightline::server
