// SQLite's default VFS, whose calls fail when they are told to.
#include "tests/server/store/failing_vfs.h"

#include <sqlite3.h>

#include <cerrno>

#include "tests/server/store/failing_files.h"

namespace sightline::tests {
namespace {

/// A file, followed in memory by that of the real VFS.
struct File {
  sqlite3_file base;
  FailingFiles* files;
};

sqlite3_file* real(sqlite3_file* file) {
  return reinterpret_cast<sqlite3_file*>(reinterpret_cast<File*>(file) + 1);
}

sqlite3_vfs* real(sqlite3_vfs* /*vfs*/) { return sqlite3_vfs_find(nullptr); }

thread_local int last_error = 0;

/// SQLITE_OK, or the code that a call of this name fails with.
int next(FailingFiles& files, const char* name, int code) {
  const int number = files.next(name);
  if (number == 0) return SQLITE_OK;
  last_error = number;
  return number == ENOSPC && code == SQLITE_IOERR_WRITE ? SQLITE_FULL : code;
}

int next(sqlite3_file* file, const char* name, int code) {
  return next(*reinterpret_cast<File*>(file)->files, name, code);
}

int close_file(sqlite3_file* file) { return real(file)->pMethods->xClose(real(file)); }

int read_file(sqlite3_file* file, void* to, int size, sqlite3_int64 offset) {
  const int code = next(file, "database read", SQLITE_IOERR_READ);
  return code != SQLITE_OK ? code : real(file)->pMethods->xRead(real(file), to, size, offset);
}

int write_file(sqlite3_file* file, const void* from, int size, sqlite3_int64 offset) {
  const int code = next(file, "database write", SQLITE_IOERR_WRITE);
  return code != SQLITE_OK ? code : real(file)->pMethods->xWrite(real(file), from, size, offset);
}

int truncate_file(sqlite3_file* file, sqlite3_int64 size) {
  const int code = next(file, "database truncate", SQLITE_IOERR_TRUNCATE);
  return code != SQLITE_OK ? code : real(file)->pMethods->xTruncate(real(file), size);
}

int sync_file(sqlite3_file* file, int flags) {
  const int code = next(file, "database sync", SQLITE_IOERR_FSYNC);
  return code != SQLITE_OK ? code : real(file)->pMethods->xSync(real(file), flags);
}

int map_shared(sqlite3_file* file, int page, int size, int extend, void volatile** to) {
  const int code = next(file, "database mmap", SQLITE_IOERR_SHMMAP);
  return code != SQLITE_OK ? code
                           : real(file)->pMethods->xShmMap(real(file), page, size, extend, to);
}

constexpr sqlite3_io_methods kMethods{
    2,
    close_file,
    read_file,
    write_file,
    truncate_file,
    sync_file,
    [](sqlite3_file* f, sqlite3_int64* size) {
      return real(f)->pMethods->xFileSize(real(f), size);
    },
    [](sqlite3_file* f, int lock) { return real(f)->pMethods->xLock(real(f), lock); },
    [](sqlite3_file* f, int lock) { return real(f)->pMethods->xUnlock(real(f), lock); },
    [](sqlite3_file* f, int* held) { return real(f)->pMethods->xCheckReservedLock(real(f), held); },
    [](sqlite3_file* f, int op, void* at) {
      return real(f)->pMethods->xFileControl(real(f), op, at);
    },
    [](sqlite3_file* f) { return real(f)->pMethods->xSectorSize(real(f)); },
    [](sqlite3_file* f) { return real(f)->pMethods->xDeviceCharacteristics(real(f)); },
    map_shared,
    [](sqlite3_file* f, int at, int n, int flags) {
      return real(f)->pMethods->xShmLock(real(f), at, n, flags);
    },
    [](sqlite3_file* f) { real(f)->pMethods->xShmBarrier(real(f)); },
    [](sqlite3_file* f, int remove) { return real(f)->pMethods->xShmUnmap(real(f), remove); },
    nullptr,
    nullptr,
};

int open_file(sqlite3_vfs* vfs, const char* name, sqlite3_file* file, int flags, int* opened) {
  auto& files = *static_cast<FailingFiles*>(vfs->pAppData);
  file->pMethods = nullptr;
  if (const int code = next(files, "database open", SQLITE_CANTOPEN); code != SQLITE_OK)
    return code;
  const int code = real(vfs)->xOpen(real(vfs), name, real(file), flags, opened);
  if (code != SQLITE_OK) return code;
  reinterpret_cast<File*>(file)->files = &files;
  file->pMethods = &kMethods;
  return SQLITE_OK;
}

int delete_file(sqlite3_vfs* vfs, const char* name, int sync) {
  auto& files = *static_cast<FailingFiles*>(vfs->pAppData);
  const int code = next(files, "database remove", SQLITE_IOERR_DELETE);
  return code != SQLITE_OK ? code : real(vfs)->xDelete(real(vfs), name, sync);
}

}  // namespace

std::unique_ptr<sqlite3_vfs> register_failing_vfs(FailingFiles& files, const std::string& name) {
  const sqlite3_vfs& base = *sqlite3_vfs_find(nullptr);
  auto vfs = std::make_unique<sqlite3_vfs>(base);
  vfs->szOsFile = static_cast<int>(sizeof(File)) + base.szOsFile;
  vfs->pNext = nullptr;
  vfs->zName = name.c_str();
  vfs->pAppData = &files;
  vfs->xOpen = open_file;
  vfs->xDelete = delete_file;
  vfs->xAccess = [](sqlite3_vfs* v, const char* file, int flags, int* result) {
    return real(v)->xAccess(real(v), file, flags, result);
  };
  vfs->xFullPathname = [](sqlite3_vfs* v, const char* file, int size, char* to) {
    return real(v)->xFullPathname(real(v), file, size, to);
  };
  vfs->xGetLastError = [](sqlite3_vfs*, int, char*) { return last_error; };
  sqlite3_vfs_register(vfs.get(), 0);
  return vfs;
}

void unregister(sqlite3_vfs& vfs) { sqlite3_vfs_unregister(&vfs); }

}  // namespace sightline::tests
