#include "core/error.hpp"

namespace sanatrix {

int exit_code(Fault fault) {
  switch (fault) {
    case Fault::Usage:
      return 1;
    case Fault::Input:
      return 2;
    case Fault::Numerics:
      return 3;
    case Fault::Resource:
      return 4;
    case Fault::Internal:
      break;
  }
  return 6;
}

std::string Error::one_line() const {
  std::string text;
  for (auto activity = trail_.rbegin(); activity != trail_.rend(); ++activity) {
    text += *activity + ": ";
  }
  text += what_;
  if (!hint_.empty()) {
    text += " - " + hint_;
  }
  for (char& c : text) {
    if (c == '\n') {
      c = ' ';
    }
  }
  return text;
}

}  // namespace sanatrix
