// Runs cases and writes what came out: the table for people, JSON for machines, and the
// credibility page of docs/credibility in the order of ASME V&V 40.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "verification/case.hpp"

namespace sanatrix::verification {

struct CaseResult {
  const Case* which;
  Findings found;
  double seconds = 0.0;
  [[nodiscard]] bool pass() const;
};

/// Cases whose key is `only` or starts with it; all when empty. Error{Usage} when there is none.
std::vector<const Case*> select(const std::string& only);
/// A case that throws has failed, not the program: its error becomes a check that does not pass.
CaseResult run(const Case& which, const Context& ctx);

std::string table_text(const std::vector<CaseResult>& results);
std::string results_json(const std::vector<CaseResult>& results);
/// README.md and one SVG per plot. Error{Resource} when they cannot be written.
void write_page(const std::vector<CaseResult>& results, const std::filesystem::path& folder);

}  // namespace sanatrix::verification
