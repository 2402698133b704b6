// BackupService: copies of what the server keeps on disk.
#pragma once

#include "server/exec/call_registry.h"
#include "server/scenes/services.h"
#include "server/store/store.h"
#include "sightline/v1/backup.grpc.pb.h"

namespace sightline::server::durable {

/// Backups and restores at a time.
inline constexpr std::size_t kMaxBackupCalls = 2;

class BackupRpc : public v1::BackupService::CallbackService {
 public:
  struct Parts {
    const scenes::Services& services;
    exec::MemoryAccount& memory;
    store::Store* store = nullptr;  ///< Null: scenes are in memory only.
    exec::CallRegistry& calls;      ///< The open calls.
  };
  /// The parts outlive this object.
  explicit BackupRpc(const Parts& parts) : parts_(parts) {}

  grpc::ServerWriteReactor<v1::BackupResponse>* Backup(grpc::CallbackServerContext* context,
                                                       const v1::BackupRequest* request) override;
  grpc::ServerReadReactor<v1::RestoreRequest>* Restore(grpc::CallbackServerContext* context,
                                                       v1::RestoreResponse* reply) override;

 private:
  const Parts parts_;
};

}  // namespace sightline::server::durable
