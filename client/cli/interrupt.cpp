// The handler may do next to nothing: it wakes a thread, which does the rest.
#include "client/cli/interrupt.h"

#include <semaphore.h>

#include <atomic>
#include <cerrno>

namespace sightline::client::cli {
namespace {

sem_t woken;
std::atomic<bool> caught{false};
static_assert(std::atomic<bool>::is_always_lock_free, "it is written by a signal handler");

void handle(int) {
  const int kept = errno;
  caught.store(true, std::memory_order_relaxed);
  sem_post(&woken);
  errno = kept;
}

}  // namespace

Interrupt::Interrupt() {
  sem_init(&woken, 0, 0);
  caught.store(false, std::memory_order_relaxed);
  waiter_ = std::thread([this] { wait(); });
  struct sigaction action {};
  action.sa_handler = handle;
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, &before_);
}

Interrupt::~Interrupt() {
  sigaction(SIGINT, &before_, nullptr);
  sem_post(&woken);
  waiter_.join();
  sem_destroy(&woken);
}

void Interrupt::wait() {
  while (sem_wait(&woken) != 0) {
  }
  if (caught.load(std::memory_order_relaxed)) stop_.request_stop();
}

}  // namespace sightline::client::cli
