// ServerService.
#include "server/updates/info_rpc.h"

namespace sightline::server::updates {

grpc::ServerUnaryReactor* InfoRpc::GetServerInfo(grpc::CallbackServerContext* context,
                                                 const v1::GetServerInfoRequest*,
                                                 v1::GetServerInfoResponse* reply) {
  *reply = info_;
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  reactor->Finish(grpc::Status::OK);
  return reactor;
}

}  // namespace sightline::server::updates
