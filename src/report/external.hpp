// Programs that are used when they are there: a browser for PDF, ffmpeg for videos. No shell.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/context.hpp"

namespace sanatrix::report {

/// Runs a program found on PATH to its end, silently. Returns why it did not succeed, or nothing.
/// Stop of `ctx` kills it and throws Cancelled.
std::optional<std::string> run_external(const std::string& program,
                                        const std::vector<std::string>& arguments,
                                        int limit_seconds, const Context& ctx);

}  // namespace sanatrix::report
