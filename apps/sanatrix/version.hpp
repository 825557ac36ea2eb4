// What this program was made of.
#pragma once

#include <string>

namespace sanatrix::app {

struct Version {
  std::string number, commit, compiler, build, libraries;
};
const Version& version();
std::string version_text();  ///< several lines, with the notice of use

}  // namespace sanatrix::app
