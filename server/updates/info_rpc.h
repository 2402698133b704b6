// ServerService.
#pragma once

#include "sightline/v1/server.grpc.pb.h"

namespace sightline::server::updates {

class InfoRpc final : public v1::ServerService::CallbackService {
 public:
  explicit InfoRpc(v1::GetServerInfoResponse info) : info_(std::move(info)) {}

  grpc::ServerUnaryReactor* GetServerInfo(grpc::CallbackServerContext* context,
                                          const v1::GetServerInfoRequest* request,
                                          v1::GetServerInfoResponse* reply) override;

 private:
  const v1::GetServerInfoResponse info_;  // constant while the server runs
};

}  // namespace sightline::server::updates
