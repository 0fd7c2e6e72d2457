#include "run/watchdog.hpp"

#include <chrono>
#include <ctime>
#include <utility>

namespace ductile::drivers {
namespace {

double processor_seconds() {
  timespec spent{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &spent);
  constexpr double nano = 1e-9;
  return static_cast<double>(spent.tv_sec) + nano * static_cast<double>(spent.tv_nsec);
}

}  // namespace

Watchdog::Watchdog(double patience, End end) : patience_(patience), end_(std::move(end)) {
  if (patience_ > 0) thread_ = std::thread([this] { watch(); });
}

Watchdog::~Watchdog() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    over_ = true;
  }
  over_changed_.notify_one();
  thread_.join();
}

void Watchdog::watch() {
  std::unique_lock lock(mutex_);
  std::int64_t seen = ticks_;
  double since = processor_seconds();
  while (!over_changed_.wait_for(lock, std::chrono::seconds(1), [this] { return over_; })) {
    const double now = processor_seconds();
    if (const std::int64_t ticks = ticks_; ticks != seen) {
      seen = ticks;
      since = now;
    } else if (now - since >= patience_) {
      end_(step_);
      return;
    }
  }
}

}  // namespace ductile::drivers
