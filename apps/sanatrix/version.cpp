#include "version.hpp"

#include <fmt/format.h>

namespace sanatrix::app {

const Version& version() {
  static const Version made{SANATRIX_VERSION, SANATRIX_COMMIT, "g++ " __VERSION__, SANATRIX_BUILD,
                            SANATRIX_LIBRARIES};
  return made;
}

std::string version_text() {
  const Version& v = version();
  return fmt::format(
      "sanatrix {} (commit {}, {}, {})\n{}\n"
      "Research use only. Not a medical device. Not for diagnosis or treatment decisions.",
      v.number, v.commit, v.compiler, v.build, v.libraries);
}

}  // namespace sanatrix::app
