#include "run/signals.hpp"

namespace ductile::drivers {
namespace {

volatile std::sig_atomic_t stop_requested = 0;
int depth = 0;  // of StopSignals inside each other

extern "C" void request_stop(int signal) {
  stop_requested = 1;
  std::signal(signal, SIG_DFL);
}

}  // namespace

StopSignals::StopSignals() {
  if (depth++ > 0) return;
  stop_requested = 0;
  struct sigaction action {};
  action.sa_handler = request_stop;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  for (std::size_t n = 0; n < signals.size(); ++n) sigaction(signals[n], &action, &before_[n]);
}

StopSignals::~StopSignals() {
  if (--depth > 0) return;
  for (std::size_t n = 0; n < signals.size(); ++n) sigaction(signals[n], &before_[n], nullptr);
}

bool StopSignals::received() const {
  return stop_requested != 0;
}

}  // namespace ductile::drivers
