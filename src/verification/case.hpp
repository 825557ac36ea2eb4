// A verification or validation case: a computation, and numbers that it must meet. The one place
// where they are computed; tests and `sanatrix verify` only ask for them.
#pragma once

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "core/context.hpp"

namespace sanatrix::verification {

/// One number against what it should be.
struct Check {
  std::string name;
  double computed = 0.0;
  double reference = std::numeric_limits<double>::quiet_NaN();  ///< NaN: only the interval counts
  double low = 0.0, high = 0.0;  ///< passes within low ... high, both included
  std::string unit;
  std::string reason;  ///< of the tolerance

  /// Distance from the reference, or from the interval.
  [[nodiscard]] double error() const;
  [[nodiscard]] bool pass() const;
};
Check near(std::string name, double reference, double computed, double tolerance, std::string unit,
           std::string reason);
Check within(std::string name, double low, double high, double computed, std::string unit,
             std::string reason);

struct Curve {
  std::string name;
  std::vector<double> x, y;
  bool markers_only = false;
  std::vector<double> error_bar{};  ///< per point, half length; empty: none
};
struct Plot {
  std::string title, x_label, y_label;
  std::vector<Curve> curves{};
  bool log_x = false, log_y = false;
};
struct Table {
  std::string title;
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;
};

struct Findings {
  std::vector<Check> checks;
  std::vector<Plot> plots;
  std::vector<Table> tables;
  std::string skipped;  ///< why nothing was computed; empty: it was
};

/// Chapters of ASME V&V 40.
enum class Chapter { CodeVerification, CalculationVerification, Validation };
enum class Cost { Fast, Full };  ///< Full only in `sanatrix verify`, Fast also in the tests

struct Case {
  std::string key;    ///< "mms-p1p1"
  std::string title;  ///< "Manufactured solution, P1/P1"
  Chapter chapter;
  Cost cost;
  std::string about;  ///< what is computed and where the reference comes from; Markdown
  std::function<Findings(const Context&)> run;
};

/// All cases in the order of the page.
const std::vector<Case>& all_cases();

/// Observed order between neighbours of a sequence of errors over sizes.
std::vector<double> observed_orders(const std::vector<double>& size,
                                    const std::vector<double>& error);

/// The shared development data (SANATRIX_SHARED), or an empty path.
std::string shared_file(const std::string& relative);

}  // namespace sanatrix::verification
