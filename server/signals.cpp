// What the program does on signals.
#include "server/signals.h"

#include <pthread.h>

namespace sightline::server {

Signals::Signals() {
  sigemptyset(&awaited_);
  for (const int number : {SIGTERM, SIGINT, SIGHUP}) sigaddset(&awaited_, number);
  pthread_sigmask(SIG_BLOCK, &awaited_, nullptr);
  for (const int number :
       {SIGUSR1, SIGUSR2, SIGPIPE, SIGALRM, SIGVTALRM, SIGPROF, SIGIO, SIGPWR, SIGSTKFLT})
    signal(number, SIG_IGN);
  for (int number = SIGRTMIN; number <= SIGRTMAX; ++number) signal(number, SIG_IGN);
}

void Signals::let_go() const { pthread_sigmask(SIG_UNBLOCK, &awaited_, nullptr); }

int Signals::wait_for_end(const std::function<void()>& on_hangup) const {
  for (;;) {
    int caught = 0;
    if (sigwait(&awaited_, &caught) != 0) continue;
    if (caught != SIGHUP) return caught;
    on_hangup();
  }
}

}  // namespace sightline::server
