// SQLite's default VFS, whose calls fail when they are told to.
#pragma once

#include <memory>
#include <string>

struct sqlite3_vfs;

namespace sightline::tests {

class FailingFiles;

/// Registers a VFS of this name whose calls `files` counts. Both outlive the VFS.
std::unique_ptr<sqlite3_vfs> register_failing_vfs(FailingFiles& files, const std::string& name);
void unregister(sqlite3_vfs& vfs);

}  // namespace sightline::tests
