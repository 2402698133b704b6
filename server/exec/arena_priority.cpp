// How threads share the processors while they work in an arena.
#include "server/exec/arena_priority.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <thread>

namespace sightline::server::exec {
namespace {

/// The argument of sched_setattr(2), for which the C library has no function. All zero:
/// SCHED_OTHER.
struct SchedulingAttributes {
  std::uint32_t size = sizeof(SchedulingAttributes);
  std::uint32_t policy = 0;
  std::uint64_t flags = 0;
  std::int32_t nice = 0;
  std::uint32_t priority = 0;
  std::uint64_t runtime = 0;  // nanoseconds
  std::uint64_t deadline = 0;
  std::uint64_t period = 0;
};

int process_nice() {
  static const int kNice = getpriority(PRIO_PROCESS, static_cast<id_t>(getpid()));
  return kNice;
}

bool may_return_from_nice() {
  static const bool kMay = [] {
    bool returned = false;
    std::thread([&] { returned = set_priority({.nice = 1}) && set_priority({}); }).join();
    return returned;
  }();
  return kMay;
}

}  // namespace

bool set_priority(const Priority& priority) {
  SchedulingAttributes attributes;
  attributes.nice = process_nice() + priority.nice;
  attributes.runtime = static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::nanoseconds>(priority.time_slice).count());
  return syscall(SYS_sched_setattr, 0, &attributes, 0) == 0;
}

Priority permitted(const Priority& priority) {
  return {.nice = may_return_from_nice() ? priority.nice : 0, .time_slice = priority.time_slice};
}

void restore_niceness() {
  const int tasks = open("/proc/self/task", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (tasks < 0) return;
  alignas(dirent64) std::array<char, 4096> entries;
  for (;;) {
    const auto read = getdents64(tasks, entries.data(), entries.size());
    if (read <= 0) break;
    for (std::size_t at = 0; at < static_cast<std::size_t>(read);) {
      const auto* entry = reinterpret_cast<const dirent64*>(entries.data() + at);
      const auto thread = static_cast<id_t>(std::strtoul(entry->d_name, nullptr, 10));
      if (thread != 0) setpriority(PRIO_PROCESS, thread, process_nice());
      at += entry->d_reclen;
    }
  }
  close(tasks);
}

ArenaPriority::ArenaPriority(oneapi::tbb::task_arena& arena, const Priority& priority)
    : task_scheduler_observer(arena), priority_(permitted(priority)) {
  if (priority_.nice != 0 || priority_.time_slice.count() != 0) observe(true);
}

ArenaPriority::~ArenaPriority() {
  // A thread that left later would not be observed, and would keep the priority.
  while (const int inside = inside_.load()) inside_.wait(inside);
  observe(false);
}

void ArenaPriority::on_scheduler_entry(bool is_worker) {
  if (!is_worker) return;
  ++inside_;
  set_priority(priority_);
}

void ArenaPriority::on_scheduler_exit(bool is_worker) {
  if (!is_worker) return;
  set_priority({});
  if (--inside_ == 0) inside_.notify_all();
}

}  // namespace sightline::server::exec
