// Backups: the parts that a server sends go into a file, and from there to a server.
#include "client/backup.h"

#include <algorithm>
#include <utility>

#include "client/backup_file.h"
#include "client/calls/connection.h"
#include "client/client.h"

namespace sightline::client {
namespace {

namespace v1 = ::sightline::v1;

/// A scene that begins again replaces its earlier parts.
void note(const v1::BackupScene& begun, std::vector<BackupScene>& scenes) {
  const std::string& name = begun.scene().name();
  std::erase_if(scenes, [&](const BackupScene& scene) { return scene.name == name; });
  scenes.push_back({name, begun.base(), begun.revision()});
}

Status send_parts(BackupFileReader& file, v1::RestoreRequest request,
                  grpc::ClientWriter<v1::RestoreRequest>& call) {
  for (;;) {
    const auto more = file.next(*request.mutable_part());
    if (!more) return more.error();
    if (!*more || !call.Write(request)) return {};  // if the call has ended, it says why
    request.clear_scene();
    request.clear_revision();
  }
}

}  // namespace

Result<std::vector<BackupScene>> Client::backup(const std::filesystem::path& directory,
                                                const BackupOptions& options) const {
  connection_->wait_until_connected();
  auto file = BackupFileWriter::create(directory, options.since);
  if (!file) return file.error();
  grpc::ClientContext context;
  calls::set_timeout(context, connection_->timeout);
  const std::stop_callback cancel(options.stop, [&] { context.TryCancel(); });
  v1::BackupRequest request;
  request.set_scene(options.scene);
  for (std::string& digest : file->known()) request.add_known_meshes(std::move(digest));
  const auto call = connection_->backups->Backup(&context, request);
  std::vector<BackupScene> scenes;
  Status kept;
  for (v1::BackupResponse response; call->Read(&response);) {
    if (response.part().has_scene()) note(response.part().scene(), scenes);
    if (kept) kept = file->add(response.part());
    if (!kept) context.TryCancel();
  }
  const grpc::Status status = call->Finish();
  if (!kept) return kept.error();
  if (!status.ok()) return calls::rpc_error(status, options.stop);
  if (const Status finished = file->finish(); !finished) return finished.error();
  return scenes;
}

Result<std::vector<RestoredScene>> Client::restore(const std::filesystem::path& directory,
                                                   const RestoreOptions& options) const {
  auto file = BackupFileReader::open(directory);
  if (!file) return file.error();
  connection_->wait_until_connected();
  grpc::ClientContext context;
  calls::set_timeout(context, connection_->timeout);
  const std::stop_callback cancel(options.stop, [&] { context.TryCancel(); });
  v1::RestoreResponse response;
  const auto call = connection_->backups->Restore(&context, &response);
  v1::RestoreRequest first;
  first.set_scene(options.scene);
  first.set_revision(options.revision);
  const Status sent = send_parts(*file, std::move(first), *call);
  if (!sent) context.TryCancel();
  call->WritesDone();
  const grpc::Status status = call->Finish();
  if (!sent) return sent.error();
  if (!status.ok()) return calls::rpc_error(status, options.stop);
  std::vector<RestoredScene> scenes;
  for (const v1::RestoredScene& scene : response.scenes())
    scenes.push_back({scene.name(), scene.revision().revision(), scene.revision().token()});
  return scenes;
}

}  // namespace sightline::client
