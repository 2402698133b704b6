// A call that completes later: by a completion, as a std::future, or for a coroutine.
#pragma once

#if __cplusplus < 202002L
#error "The client of Sightline needs C++20: compile with -std=c++20 or later"
#endif

#include <concepts>
#include <coroutine>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <utility>

#include "client/result.h"

namespace sightline::client {

/// Runs each task once, now or later, on a thread of its choice: it may put tasks in the queue of a
/// game's loop. It is called by threads of gRPC, and must neither throw nor drop a task: the
/// completion of a dropped task never runs. An empty executor leaves tasks to threads of gRPC.
using Executor = std::function<void(std::function<void()> task)>;

/// A call that AsyncClient has made and that has not begun. It begins with then(), future() or
/// co_await, which return at once; each uses the call up. A call that is destroyed before is never
/// sent.
///
/// Without an executor completions run on threads of gRPC, which are few: a completion there must
/// not wait for another call. It may begin calls, and may destroy clients. A completion that throws
/// ends the program by std::terminate. No completion runs within then() itself, unless the executor
/// does so.
template <class T>
class [[nodiscard]] AsyncCall {
 public:
  using Begin = std::function<void(std::function<void(Result<T>)>)>;

  /// Made by AsyncClient.
  AsyncCall(Begin begin, Executor executor)
      : begin_(std::move(begin)), executor_(std::move(executor)) {}
  AsyncCall(AsyncCall&&) noexcept = default;
  AsyncCall& operator=(AsyncCall&&) noexcept = default;

  /// Begins the call. The executor runs `completion` once, with the result. Move-only completions
  /// are accepted.
  template <class Completion>
    requires std::invocable<Completion&, Result<T>>
  void then(Completion completion) && {
    auto kept = std::make_shared<Completion>(std::move(completion));
    // From here on another thread may complete the call and destroy what holds it.
    const Begin begin = std::move(begin_);
    begin([kept = std::move(kept),
           executor = std::move(executor_)](Result<T> result) mutable noexcept {
      auto run = [kept = std::move(kept), result = std::move(result)]() mutable noexcept {
        static_cast<void>(std::invoke(*kept, std::move(result)));
      };
      if (!executor) return run();
      executor(std::move(run));
    });
  }

  /// Begins the call. A thread of gRPC sets the future's value, whatever the executor is, so the
  /// thread of the executor may wait for it.
  std::future<Result<T>> future() && {
    auto kept = std::make_shared<std::promise<Result<T>>>();
    auto result = kept->get_future();
    const Begin begin = std::move(begin_);
    begin(
        [kept = std::move(kept)](Result<T> value) noexcept { kept->set_value(std::move(value)); });
    return result;
  }

  /// `co_await client.cast(...)` begins the call and is its result. The executor resumes the
  /// coroutine.
  auto operator co_await() && { return Awaiter{std::move(*this), {}}; }

 private:
  struct Awaiter {
    AsyncCall call;
    std::optional<Result<T>> result;

    bool await_ready() const noexcept { return false; }
    void await_suspend(std::coroutine_handle<> waiting) {
      std::move(call).then([this, waiting](Result<T> got) {
        result.emplace(std::move(got));
        waiting.resume();
      });
    }
    Result<T> await_resume() { return *std::move(result); }
  };

  Begin begin_;
  Executor executor_;
};

}  // namespace sightline::client
