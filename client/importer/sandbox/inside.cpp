// Requests over the channel; the result goes to a file in memory.
#include "client/importer/sandbox/inside.h"

#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>

#include "client/importer/sandbox/channel.h"
#include "client/importer/sandbox/confine.h"

namespace sightline::client::importer::sandbox {
namespace {

constexpr std::size_t kWriteBytes = std::size_t{1} << 18;

[[noreturn]] void give_up() { ::_exit(1); }

}  // namespace

std::optional<std::string_view> Inside::read(const std::string& name) {
  const Request request = Request::of(Request::Kind::kOpen, name);
  if (request.length < name.size()) return {};
  Reply reply;
  FileHandle file;
  if (!send(kChannel, request) || !receive(kChannel, reply, &file)) give_up();
  if (!file) return {};
  if (const auto known = files_.find(reply.number); known != files_.end()) return known->second;
  if (reply.bytes == 0) return std::string_view();
  void* const bytes =
      ::mmap(nullptr, reply.bytes, PROT_READ, MAP_PRIVATE | MAP_POPULATE, file.get(), 0);
  if (bytes == MAP_FAILED) return {};
  return files_[reply.number] = {static_cast<const char*>(bytes), reply.bytes};
}

void Inside::progress(double part) {
  Request request = Request::of(Request::Kind::kProgress);
  request.part = part;
  if (!send(kChannel, request)) give_up();
}

void Inside::write(const void* bytes, std::size_t count) {
  const std::string_view text(static_cast<const char*>(bytes), count);
  if (count < kWriteBytes) {
    buffer_ += text;
    if (buffer_.size() >= kWriteBytes) flush();
    return;
  }
  flush();
  send_out(text);
}

void Inside::flush() {
  send_out(buffer_);
  buffer_.clear();
}

void Inside::send_out(std::string_view rest) {
  written_ += rest.size();
  while (!rest.empty()) {
    const ssize_t count = ::write(kResult, rest.data(), rest.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) {
      (void)send(kChannel, Request::of(Request::Kind::kOutOfMemory));
      give_up();
    }
    rest.remove_prefix(static_cast<std::size_t>(count));
  }
}

void Inside::finish() {
  flush();
  Request request = Request::of(Request::Kind::kDone);
  request.bytes = written_;
  (void)send(kChannel, request);
  ::_exit(0);
}

}  // namespace sightline::client::importer::sandbox
