// The report's sections as HTML.
#pragma once

#include <filesystem>
#include <string>

#include "report/findings.hpp"
#include "report/report.hpp"

namespace sanatrix::report {

std::string notice();
std::string plan_section(const Findings& findings, const std::filesystem::path& outcome);
std::string views_section(const Findings& findings, const std::filesystem::path& pictures);
std::string metrics_section(const Findings& findings);
std::string healing_section(const Findings& findings);
/// Empty without a follow-up scan.
std::string validation_section(const Findings& findings, const std::filesystem::path& pictures);
std::string model_section(const Findings& findings, const std::filesystem::path& outcome);
std::string provenance_section(const Findings& findings, const Program& program);
std::string limits_section();

/// "12.3", with a real minus sign; a dash for null.
std::string shown(const nlohmann::json& value, int digits = 1);

}  // namespace sanatrix::report
