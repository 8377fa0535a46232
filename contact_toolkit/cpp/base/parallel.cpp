#include "base/parallel.h"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

namespace contact_toolkit {
namespace {

thread_local bool inside_loop = false;

// One loop; workers that wake up late find it exhausted and leave it alone.
struct Loop {
  Loop(int count, const std::function<void(int, int)>& body) : count(count), body(body) {}

  void Run(int worker) {
    inside_loop = true;
    for (int i = next++; i < count; i = next++) {
      try {
        body(i, worker);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (!error) error = std::current_exception();
        next = count;
      }
    }
    inside_loop = false;
  }

  const int count;
  const std::function<void(int, int)>& body;
  std::atomic<int> next{0};
  std::mutex mutex;
  std::exception_ptr error;
};

// Threads that sleep between loops: starting one anew would cost more than most queries.
class Pool {
 public:
  ~Pool() {
    {
      const std::lock_guard lock(mutex_);
      stop_ = true;
    }
    wake_.notify_all();
    for (std::thread& thread : threads_) thread.join();
  }

  // Runs the loop on this thread and up to `helpers` others; returns when all are done with it.
  void Run(Loop* loop, int helpers) {
    {
      const std::lock_guard lock(mutex_);
      while (static_cast<int>(threads_.size()) < helpers) {
        threads_.emplace_back([this] { Work(); });
      }
      loop_ = loop;
      wanted_ = helpers;
      joined_ = 0;
    }
    wake_.notify_all();
    loop->Run(0);
    std::unique_lock lock(mutex_);
    wanted_ = 0;
    loop_ = nullptr;
    done_.wait(lock, [this] { return busy_ == 0; });
  }

 private:
  void Work() {
    std::unique_lock lock(mutex_);
    while (true) {
      wake_.wait(lock, [this] { return stop_ || joined_ < wanted_; });
      if (stop_) return;
      Loop* loop = loop_;
      const int worker = ++joined_;
      ++busy_;
      lock.unlock();
      loop->Run(worker);
      lock.lock();
      if (--busy_ == 0) done_.notify_all();
    }
  }

  std::mutex mutex_;
  std::condition_variable wake_, done_;
  std::vector<std::thread> threads_;
  Loop* loop_ = nullptr;
  int wanted_ = 0, joined_ = 0, busy_ = 0;
  bool stop_ = false;
};

// One pool at a time is lent out; a second Python thread that asks meanwhile works alone.
std::mutex pool_mutex;

Pool* ThePool() {
  static std::unique_ptr<Pool> pool;
  static pid_t owner = 0;
  if (owner != getpid()) {
    // After fork() the threads exist in the parent alone: leave its pool behind.
    static_cast<void>(pool.release());
    pool = std::make_unique<Pool>();
    owner = getpid();
  }
  return pool.get();
}

}  // namespace

void ParallelFor(int count, int threads, const std::function<void(int, int)>& body) {
  std::unique_lock pool_lock(pool_mutex, std::defer_lock);
  if (threads <= 1 || count <= 1 || inside_loop || !pool_lock.try_lock()) {
    for (int i = 0; i < count; ++i) body(i, 0);
    return;
  }
  Loop loop(count, body);
  ThePool()->Run(&loop, std::min(threads, count) - 1);
  if (loop.error) std::rethrow_exception(loop.error);
}

}  // namespace contact_toolkit
