#include "verification/credibility.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "core/files.hpp"
#include "verification/credibility_text.hpp"
#include "verification/svg_plot.hpp"

namespace sanatrix::verification {
namespace {

using nlohmann::json;

bool has_reference(const Check& check) {
  return !std::isnan(check.reference);
}

/// Numbers far below what the check is about are round-off and differ between machines.
std::string shown(double value, double scale, int digits) {
  return std::abs(value) < 1e-4 * scale ? "~0" : fmt::format("{:.{}g}", value, digits);
}

std::string reference_text(const Check& c) {
  if (has_reference(c)) {
    return fmt::format("{:.5g}", c.reference);
  }
  const bool upper = c.low == 0.0;
  return upper ? fmt::format("<= {:.3g}", c.high) : fmt::format("{:.5g} ... {:.5g}", c.low, c.high);
}

std::string computed_text(const Check& c) {
  return shown(c.computed, has_reference(c) ? std::abs(c.high - c.low) : c.high, 5);
}

std::string error_text(const Check& c) {
  return shown(c.error(), std::abs(c.high - c.low), 2);
}

std::string tolerance_text(const Check& c) {
  return has_reference(c)
             ? fmt::format("{:.2g}", std::max(c.high - c.reference, c.reference - c.low))
             : "";
}

std::string plot_file(const CaseResult& result, std::size_t plot) {
  const bool several = result.found.plots.size() > 1;
  return several ? fmt::format("{}-{}.svg", result.which->key, plot + 1)
                 : result.which->key + ".svg";
}

std::string case_section(const CaseResult& result) {
  const Case& one = *result.which;
  std::string text = fmt::format("\n<a id=\"{1}\"></a>\n\n### {0}\n\n`{1}`. {2}\n\n", one.title,
                                 one.key, one.about);
  if (!result.found.skipped.empty()) {
    return text + fmt::format("Not run: {}.\n", result.found.skipped);
  }
  text +=
      "| check | unit | reference | computed | error | tolerance | | why this tolerance |\n"
      "| --- | --- | ---: | ---: | ---: | ---: | --- | --- |\n";
  for (const Check& c : result.found.checks) {
    text += fmt::format("| {} | {} | {} | {} | {} | {} | {} | {} |\n", c.name, c.unit,
                        reference_text(c), computed_text(c), error_text(c), tolerance_text(c),
                        c.pass() ? "pass" : "**FAIL**", c.reason);
  }
  for (const Table& table : result.found.tables) {
    text += fmt::format("\n{}\n\n| {} |\n|", table.title, fmt::join(table.header, " | "));
    for (std::size_t i = 0; i < table.header.size(); ++i) {
      text += " ---: |";
    }
    for (const auto& row : table.rows) {
      text += fmt::format("\n| {} |", fmt::join(row, " | "));
    }
    text += "\n";
  }
  for (std::size_t p = 0; p < result.found.plots.size(); ++p) {
    text += fmt::format("\n![{}]({})\n", one.title, plot_file(result, p));
  }
  return text;
}

std::string chapter(const std::vector<CaseResult>& results, Chapter wanted, const char* head) {
  std::string text = head;
  for (const CaseResult& result : results) {
    text += result.which->chapter == wanted ? case_section(result) : "";
  }
  return text;
}

std::string summary(const std::vector<CaseResult>& results) {
  std::string text = "\n## Summary\n\n| case | checks | passed |\n| --- | ---: | --- |\n";
  for (const CaseResult& r : results) {
    const auto passed = std::ranges::count_if(r.found.checks, &Check::pass);
    text += fmt::format("| [{0}](#{1}) | {2} | {3} |\n", r.which->title, r.which->key,
                        r.found.checks.size(),
                        !r.found.skipped.empty() ? "not run"
                        : r.pass()               ? "all"
                                                 : fmt::format("**{}**", passed));
  }
  return text;
}

const char* name_of(Chapter chapter) {
  switch (chapter) {
    case Chapter::CodeVerification:
      return "code verification";
    case Chapter::CalculationVerification:
      return "calculation verification";
    case Chapter::Validation:
      break;
  }
  return "validation";
}

json check_json(const Check& c) {
  json j{{"check", c.name}, {"unit", c.unit},     {"computed", c.computed}, {"low", c.low},
         {"high", c.high},  {"error", c.error()}, {"pass", c.pass()},       {"reason", c.reason}};
  j["reference"] = has_reference(c) ? json(c.reference) : json();
  return j;
}

}  // namespace

bool CaseResult::pass() const {
  return std::ranges::all_of(found.checks, &Check::pass);
}

std::vector<const Case*> select(const std::string& only) {
  std::vector<const Case*> chosen;
  std::string known;
  for (const Case& one : all_cases()) {
    if (one.key.starts_with(only)) {
      chosen.push_back(&one);
    }
    known += (known.empty() ? "" : ", ") + one.key;
  }
  if (chosen.empty()) {
    throw Error(Fault::Usage, fmt::format("there is no case '{}'", only),
                "the cases are: " + known);
  }
  return chosen;
}

CaseResult run(const Case& which, const Context& ctx) {
  const auto start = std::chrono::steady_clock::now();
  CaseResult result{&which, {}};
  try {
    result.found = which.run(ctx);
  } catch (const Error& e) {
    result.found.checks.push_back(near("runs to its end", 1.0, 0.0, 0.0, "", e.one_line()));
  }
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

std::string table_text(const std::vector<CaseResult>& results) {
  std::string text = fmt::format("{:<22} {:<58} {:>16} {:>11} {:>9}  {}\n", "case", "check",
                                 "reference", "computed", "error", "");
  for (const CaseResult& r : results) {
    for (const Check& c : r.found.checks) {
      text += fmt::format("{:<22} {:<58} {:>16} {:>11} {:>9}  {}\n", r.which->key, c.name,
                          reference_text(c), computed_text(c), error_text(c),
                          c.pass() ? "pass" : "FAIL: " + c.reason);
    }
    if (!r.found.skipped.empty()) {
      text += fmt::format("{:<22} not run: {}\n", r.which->key, r.found.skipped);
    }
  }
  return text;
}

std::string results_json(const std::vector<CaseResult>& results) {
  json cases = json::array();
  bool pass = true;
  for (const CaseResult& r : results) {
    json one{
        {"case", r.which->key}, {"title", r.which->title}, {"chapter", name_of(r.which->chapter)},
        {"pass", r.pass()},     {"seconds", r.seconds},    {"checks", json::array()}};
    for (const Check& c : r.found.checks) {
      one["checks"].push_back(check_json(c));
    }
    if (!r.found.skipped.empty()) {
      one["skipped"] = r.found.skipped;
    }
    pass = pass && r.pass();
    cases.push_back(std::move(one));
  }
  return json{{"pass", pass}, {"cases", cases}}.dump(2) + "\n";
}

void write_page(const std::vector<CaseResult>& results, const std::filesystem::path& folder) {
  std::error_code problem;
  std::filesystem::create_directories(folder, problem);
  if (problem) {
    throw Error(Fault::Resource, fmt::format("{}: the folder cannot be made: {}",
                                             folder.filename().string(), problem.message()));
  }
  for (const CaseResult& r : results) {
    for (std::size_t p = 0; p < r.found.plots.size(); ++p) {
      write_text(folder / plot_file(r, p), svg_plot(r.found.plots[p]));
    }
  }
  write_text(folder / "README.md",
             page_head + summary(results) + chapter(results, Chapter::CodeVerification, code_head) +
                 chapter(results, Chapter::CalculationVerification, calculation_head) +
                 chapter(results, Chapter::Validation, validation_head) + page_tail);
}

}  // namespace sanatrix::verification
