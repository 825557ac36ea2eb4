// Line plots as SVG: text that is the same on every machine, for pages under version control.
#pragma once

#include <string>

#include "verification/case.hpp"

namespace sanatrix::verification {

std::string svg_plot(const Plot& plot);

}  // namespace sanatrix::verification
