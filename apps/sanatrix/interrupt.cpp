#include "interrupt.hpp"

#include <csignal>

#include <unistd.h>

#include "core/error.hpp"

namespace sanatrix::app {
namespace {

volatile std::sig_atomic_t caught = 0;  // signal handlers may touch nothing else

void on_signal(int) {
  if (caught != 0) {
    ::_exit(exit_interrupted);
  }
  caught = 1;
}

}  // namespace

void catch_interrupts() {
  struct sigaction action {};
  action.sa_handler = on_signal;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

bool interrupted() {
  return caught != 0;
}

void pass_on(std::stop_source& stop) {
  if (interrupted()) {
    stop.request_stop();
  }
}

}  // namespace sanatrix::app
