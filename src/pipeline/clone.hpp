// A second case that starts from what a first one has computed.
#pragma once

#include <filesystem>

#include "pipeline/case.hpp"

namespace sanatrix::pipeline {

/// Makes `folder` a case with the same inputs, parameters and finished stages, up to and including
/// `last`. Files are hard links where the disk allows it, copies elsewhere: a case never changes a
/// finished file, it replaces it. Complete or absent; Error{Resource} when it cannot be made.
Case clone_case(const Case& from, const std::filesystem::path& folder, Stage last);

}  // namespace sanatrix::pipeline
