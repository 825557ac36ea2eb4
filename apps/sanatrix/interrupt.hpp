// Ctrl-C once: the work stops at its next safe point. Twice: the program stops now.
#pragma once

#include <stop_token>

namespace sanatrix::app {

/// Catches SIGINT and SIGTERM from now on.
void catch_interrupts();
[[nodiscard]] bool interrupted();
/// Turns a caught signal into a stop request; called from the main thread with every event.
void pass_on(std::stop_source& stop);

}  // namespace sanatrix::app
