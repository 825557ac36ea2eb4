// `sanatrix report` and `sanatrix compare`: everything about a case, or several, on one page.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/context.hpp"
#include "pipeline/case.hpp"

namespace sanatrix::report {

struct Program {
  std::string version, libraries, command;  ///< for the provenance table
};
enum class Animations { No, Yes };
enum class Photographs { No, Yes };  ///< may files that leave the house show the patient's skin?
struct Options {
  Animations animations = Animations::No;
  Photographs in_files = Photographs::No;
};

struct Written {
  std::filesystem::path folder;
  std::vector<std::string> files;  ///< report.html first
  std::vector<std::string> notes;  ///< what could not be made, and why
};
/// Into stages/95-report of the case, completely or not at all: report.html, report.pdf when
/// Chromium is there, pictures, GLB, OBJ, STL, and videos when asked for. Error{Input} when the
/// case is not up to date.
Written write_report(const pipeline::Case& patient, const Options& options, const Program& program,
                     const Context& ctx);

/// Cases side by side, same cameras and scales, in one HTML file. At least two.
void write_comparison(const std::vector<pipeline::Case>& cases, const Program& program,
                      const std::filesystem::path& file, const Context& ctx);

}  // namespace sanatrix::report
