#include "run/signals.hpp"

namespace ductile::drivers {
namespace {

volatile std::sig_atomic_t stop_requested = 0;
volatile std::sig_atomic_t checkpoint_requested = 0;
int depth = 0;  // of Signals inside each other

extern "C" void note_signal(int signal) {
  if (signal == SIGUSR1) {
    checkpoint_requested = 1;
    return;
  }
  stop_requested = signal;
  if (signal != SIGUSR2) std::signal(signal, SIG_DFL);
}

}  // namespace

Signals::Signals() {
  if (depth++ > 0) return;
  struct sigaction action {};
  action.sa_handler = note_signal;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  for (std::size_t n = 0; n < signals.size(); ++n) {
    sigaction(signals[n], &action, &before_[n]);
    // What runs in the background of a script is not to hear of the terminal.
    if (signals[n] == SIGINT && before_[n].sa_handler == SIG_IGN)
      sigaction(SIGINT, &before_[n], nullptr);
  }
}

Signals::~Signals() {
  if (--depth > 0) return;
  stop_requested = 0;
  checkpoint_requested = 0;
  for (std::size_t n = 0; n < signals.size(); ++n) sigaction(signals[n], &before_[n], nullptr);
}

int Signals::stop() const {
  return stop_requested;
}

bool Signals::take_checkpoint() {
  if (checkpoint_requested == 0) return false;
  checkpoint_requested = 0;
  return true;
}

void prepare_signals() {
  for (const int signal : {SIGPIPE, SIGXFSZ}) std::signal(signal, SIG_IGN);
}

}  // namespace ductile::drivers
