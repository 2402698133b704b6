// A list of the allowed system calls (seccomp): a yield ends the process, all others fail with
// EPERM.
#include "client/importer/sandbox/confine.h"

#include <fcntl.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <seccomp.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <limits>

namespace sightline::client::importer::sandbox {
namespace {

// These calls are for memory, time, locks, signals, and what needs a descriptor that is open
// already. UBSan looks whether memory can be read by writing it to a pipe.
constexpr std::array kAllowed{SCMP_SYS(brk),
                              SCMP_SYS(munmap),
                              SCMP_SYS(mremap),
                              SCMP_SYS(madvise),
                              SCMP_SYS(read),
                              SCMP_SYS(write),
                              SCMP_SYS(writev),
                              SCMP_SYS(close),
                              SCMP_SYS(lseek),
                              SCMP_SYS(fstat),
                              SCMP_SYS(sendmsg),
                              SCMP_SYS(recvmsg),
                              SCMP_SYS(futex),
                              SCMP_SYS(nanosleep),
                              SCMP_SYS(clock_gettime),
                              SCMP_SYS(clock_nanosleep),
                              SCMP_SYS(gettimeofday),
                              SCMP_SYS(getpid),
                              SCMP_SYS(gettid),
                              SCMP_SYS(getrandom),
                              SCMP_SYS(rt_sigaction),
                              SCMP_SYS(rt_sigprocmask),
                              SCMP_SYS(rt_sigreturn),
                              SCMP_SYS(sigaltstack),
                              SCMP_SYS(restart_syscall),
                              SCMP_SYS(exit),
                              SCMP_SYS(exit_group),
                              SCMP_SYS(pipe),
                              SCMP_SYS(pipe2)};

// A process of one thread yields only in a spin lock that a thread which it does not have holds.
// libseccomp cannot be asked for this filter: it allocates, and the lock may be the allocator's.
bool end_at_a_yield() {
  std::array<sock_filter, 4> filter{{
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_sched_yield, 0, 1),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_KILL_PROCESS),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
  }};
  const sock_fprog program{filter.size(), filter.data()};
  return ::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) == 0;
}

bool allow_calls() {
  const scmp_filter_ctx filter = seccomp_init(SCMP_ACT_ERRNO(EPERM));
  if (filter == nullptr) return false;
  bool good = true;
  const auto allow = [&](int call, auto... arguments) {
    good = good &&
           seccomp_rule_add(filter, SCMP_ACT_ALLOW, call, sizeof...(arguments), arguments...) == 0;
  };
  for (const int call : kAllowed) allow(call);
  const scmp_arg_cmp not_executable = SCMP_A2(SCMP_CMP_MASKED_EQ, PROT_EXEC, 0);
  allow(SCMP_SYS(mmap), not_executable);
  allow(SCMP_SYS(mprotect), not_executable);
  // abort() signals itself.
  allow(SCMP_SYS(tgkill), SCMP_A0(SCMP_CMP_EQ, static_cast<scmp_datum_t>(::getpid())));
  good = good && seccomp_load(filter) == 0;
  seccomp_release(filter);
  return good;
}

// Moves the descriptors to their places and closes all others.
bool keep_descriptors(int channel, int result) {
  constexpr int kBeyond = 64;
  const int null = ::open("/dev/null", O_RDWR | O_CLOEXEC);
  const int kept_channel = ::fcntl(channel, F_DUPFD, kBeyond);
  const int kept_result = ::fcntl(result, F_DUPFD, kBeyond);
  if (null < 0 || kept_channel < 0 || kept_result < 0) return false;
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO}) ::dup2(null, stream);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // their reports go there
  ::dup2(null, STDERR_FILENO);
#endif
  ::dup2(kept_channel, kChannel);
  ::dup2(kept_result, kResult);
  return ::close_range(kResult + 1, std::numeric_limits<unsigned>::max(), 0) == 0;
}

// Handlers of the parent have nothing to do here. What a terminal sends reaches the parent too.
void reset_signals() {
  for (int number = 1; number < NSIG; ++number) ::signal(number, SIG_DFL);
  for (const int number : {SIGINT, SIGQUIT, SIGHUP, SIGPIPE}) ::signal(number, SIG_IGN);
  sigset_t none;
  sigemptyset(&none);
  ::pthread_sigmask(SIG_SETMASK, &none, nullptr);
}

}  // namespace

const char* confine(int parent, int channel, int result) {
  constexpr const char* kNoFilter = "no filter of system calls (seccomp)";
  if (::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return "no way to give up privileges";
  if (!end_at_a_yield()) return kNoFilter;
  reset_signals();
  if (::prctl(PR_SET_PDEATHSIG, SIGKILL) != 0) return "no signal at the end of the parent";
  if (::getppid() != parent) ::_exit(1);
  const rlimit none{0, 0};
  if (::setrlimit(RLIMIT_CORE, &none) != 0) return "no limit on core dumps";
  if (!keep_descriptors(channel, result)) return "descriptors cannot be closed";
  return allow_calls() ? nullptr : kNoFilter;
}

}  // namespace sightline::client::importer::sandbox
