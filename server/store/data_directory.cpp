// The directory of an embedded store: its files, and the right to use it.
#include "server/store/data_directory.h"

#include <fmt/format.h>

#include <utility>

#include "server/store/schema.h"

namespace sightline::server::store {
namespace {

Error in_use(const std::filesystem::path& directory) {
  return {
      Code::kFailedPrecondition,
      fmt::format("another process uses {}; end it, or name another directory", directory.string()),
      "DATA_DIR_IN_USE"};
}

Error on_network(const std::filesystem::path& directory, std::string_view type) {
  return {Code::kFailedPrecondition,
          fmt::format("{} is on a network file system ({}), which does not keep what it has "
                      "acknowledged; name a directory on a local disk",
                      directory.string(), type),
          "NETWORK_FILE_SYSTEM"};
}

}  // namespace

std::filesystem::path database_file(const std::filesystem::path& directory) {
  return directory / "sightline.db";
}

Result<DataDirectory> DataDirectory::open(FileSystem& files,
                                          const std::filesystem::path& directory) {
  if (const Status made = files.make_directory(directory); !made) return made.error();
  const auto network = files.network(directory);
  if (!network) return network.error();
  if (!network->empty()) return on_network(directory, *network);
  auto lock = files.lock(directory / "lock");
  if (!lock) return lock.error().reason == "LOCKED" ? in_use(directory) : lock.error();
  return DataDirectory(files, directory, std::move(*lock));
}

Result<SqliteDatabase> DataDirectory::open_database() const {
  auto database = SqliteDatabase::open(database_file(path_), files_->database_vfs());
  if (!database) return database;
  if (const Status ready = configure(*database); !ready) return ready.error();
  if (const Status ready = prepare_tables(*database); !ready) return ready.error();
  if (const Status named = files_->sync_directory(path_); !named) return named.error();
  return database;
}

}  // namespace sightline::server::store
