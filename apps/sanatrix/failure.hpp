// Exceptions to one line on stderr and an exit code.
#pragma once

#include <exception>
#include <string>

namespace sanatrix::app {

struct Failure {
  int exit_code;
  std::string line;
};
/// Of any exception that may reach main.
Failure describe(const std::exception_ptr& problem);

}  // namespace sanatrix::app
