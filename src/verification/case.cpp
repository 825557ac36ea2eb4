#include "verification/case.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "verification/cases.hpp"

namespace sanatrix::verification {

double Check::error() const {
  if (!std::isnan(reference)) {
    return std::abs(computed - reference);
  }
  return std::max({0.0, low - computed, computed - high});
}

bool Check::pass() const {
  return computed >= low && computed <= high;  // false for NaN
}

Check near(std::string name, double reference, double computed, double tolerance, std::string unit,
           std::string reason) {
  return {std::move(name),       computed,        reference,        reference - tolerance,
          reference + tolerance, std::move(unit), std::move(reason)};
}

Check within(std::string name, double low, double high, double computed, std::string unit,
             std::string reason) {
  Check check = near(std::move(name), 0.0, computed, 0.0, std::move(unit), std::move(reason));
  check.reference = std::numeric_limits<double>::quiet_NaN();
  check.low = low;
  check.high = high;
  return check;
}

std::vector<double> observed_orders(const std::vector<double>& size,
                                    const std::vector<double>& error) {
  std::vector<double> orders;
  for (std::size_t i = 1; i < size.size(); ++i) {
    orders.push_back(std::log(error[i - 1] / error[i]) / std::log(size[i - 1] / size[i]));
  }
  return orders;
}

std::string shared_file(const std::string& relative) {
  const char* folder = std::getenv("SANATRIX_SHARED");
  if (folder == nullptr) {
    return {};
  }
  const auto file = std::filesystem::path(folder) / relative;
  return std::filesystem::exists(file) ? file.string() : std::string{};
}

const std::vector<Case>& all_cases() {
  static const std::vector<Case> cases = [] {
    std::vector<Case> list;
    for (const auto add : {add_mechanics_mms, add_healing_mms, add_closed_forms, add_cook,
                           add_membrane, add_round_trip, add_waves, add_healthy_tissue, add_spheres,
                           add_peers, add_patient, add_paper, add_clinical}) {
      add(list);
    }
    return list;
  }();
  return cases;
}

}  // namespace sanatrix::verification
