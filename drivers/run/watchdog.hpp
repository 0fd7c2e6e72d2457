// Ends a rank that waits for another one which does not come any more.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <thread>

namespace ductile::drivers {

/// Looks once a second whether anything has been done since. A rank that waits for another spends
/// processor time, and one that is stopped spends none, nor does a job that is suspended as a
/// whole: so the time that counts is the process's own.
class Watchdog {
 public:
  /// Gets the last step that was done.
  using End = std::function<void(std::int64_t step)>;
  /// Calls `end` on a thread of its own once `patience` seconds of processor time are spent without
  /// a sign of life. 0: never.
  Watchdog(double patience, End end);
  ~Watchdog();
  Watchdog(const Watchdog&) = delete;
  Watchdog& operator=(const Watchdog&) = delete;

  /// A sign of life: so many steps are done.
  void tick(std::int64_t step) {
    step_.store(step, std::memory_order_relaxed);
    ticks_.fetch_add(1, std::memory_order_relaxed);
  }

 private:
  void watch();

  double patience_;
  End end_;
  std::atomic<std::int64_t> step_ = 0;
  std::atomic<std::int64_t> ticks_ = 0;
  std::mutex mutex_;
  std::condition_variable over_changed_;
  bool over_ = false;
  std::thread thread_;
};

}  // namespace ductile::drivers
