#include "run/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "output/say.hpp"
#include "scenario/text.hpp"

namespace ductile::drivers {

namespace {
constexpr double terminal_interval = 0.25;
constexpr double first_line_interval = 10;
constexpr double last_line_interval = 300;
constexpr double million = 1e6;

/// "10" of "10.00".
std::string without_zeros(std::string decimal) {
  decimal.erase(decimal.find_last_not_of('0') + 1);
  if (decimal.ends_with('.')) decimal.pop_back();
  return decimal;
}
}  // namespace

double Progress::steady_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

Progress::Progress(double end_time, std::int64_t nodes, std::FILE* out)
    : Progress(end_time, nodes, out, isatty(fileno(out)) == 1, steady_seconds) {}

Progress::Progress(double end_time, std::int64_t nodes, std::FILE* out, bool terminal, Clock clock)
    : end_time_(end_time),
      nodes_(static_cast<double>(nodes)),
      out_(out),
      terminal_(terminal),
      clock_(std::move(clock)),
      decimals_(end_time > 0 ? std::max(2, 2 - static_cast<int>(std::floor(std::log10(end_time))))
                             : 2),
      interval_(terminal ? terminal_interval : first_line_interval) {}

void Progress::update(double time, std::int64_t step) {
  now_ = {clock_(), time, step};
  if (!started_) {
    started_ = true;
    first_ = shown_ = now_;
  }
  if (now_.clock - shown_.clock < interval_) return;
  show();
  if (!terminal_) interval_ = std::min(2 * interval_, last_line_interval);
}

void Progress::finish() {
  if (!started_) return;
  if (now_.step > shown_.step || !terminal_) show();
  if (terminal_) std::fputs("\n", out_);
  std::fflush(out_);
  started_ = false;
}

void Progress::show() {
  const double elapsed = now_.clock - shown_.clock;
  if (elapsed > 0 && now_.step > shown_.step) {
    rate_ = static_cast<double>(now_.step - shown_.step) * nodes_ / elapsed / million;
  }
  const double fraction = end_time_ > 0 ? std::clamp(now_.time / end_time_, 0.0, 1.0) : 1.0;
  std::string text = fmt::format("t = {:.{}f} of {}  {:3.0f}%  {:.1f} MLUPS", now_.time, decimals_,
                                 without_zeros(fmt::format("{:.{}f}", end_time_, decimals_)),
                                 std::floor(100 * fraction), rate_);
  const double done = now_.time - first_.time;
  const double left = end_time_ - now_.time;
  if (done > 0 && left > 0) {
    text += fmt::format("  {} left", duration_text((now_.clock - first_.clock) * left / done));
  }
  if (!note_.empty()) text += "  " + note_;
  // The escape clears what a longer line before has left.
  std::fputs((terminal_ ? "\r" + text + "\x1b[K" : text + "\n").c_str(), out_);
  if (!terminal_) note_in_log(text + "\n");
  std::fflush(out_);
  shown_ = now_;
}

}  // namespace ductile::drivers
