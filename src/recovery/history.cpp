// history.csv: the columns of the published reference histories first, in their order, then ours.
#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "recovery/recovery.hpp"

namespace sanatrix::recovery {

namespace {

struct Column {
  std::string name;
  std::vector<double> values;
};

std::vector<Column> columns(const std::vector<HistoryRow>& history, const healing::Model& model) {
  std::vector<Column> all;
  const auto add = [&](std::string name, const auto& value_of) {
    Column column{std::move(name), {}};
    for (const HistoryRow& row : history) {
      column.values.push_back(value_of(row));
    }
    all.push_back(std::move(column));
  };
  add("t_day", [](const HistoryRow& r) { return r.species.t_day; });
  for (std::size_t s = 0; s < model.species().size(); ++s) {
    add(model.species()[s].key + "_mean", [s](const HistoryRow& r) { return r.species.mean[s]; });
    add(model.species()[s].key + "_centre",
        [s](const HistoryRow& r) { return r.species.centre[s]; });
  }
  add("eta_healthy_min", [](const HistoryRow& r) { return r.species.eta_healthy_min; });
  add("eta_healthy_max", [](const HistoryRow& r) { return r.species.eta_healthy_max; });
  add("zeta_far", [](const HistoryRow& r) { return r.species.far_field_second; });
  add("V_over_V0", [](const HistoryRow& r) { return r.volume_ratio; });
  add("wall_displacement_mm", [](const HistoryRow& r) { return r.wall_displacement_mm; });
  add("max_displacement_mm", [](const HistoryRow& r) { return r.max_displacement_mm; });
  add("min_jacobian", [](const HistoryRow& r) { return r.min_jacobian; });
  return all;
}

constexpr std::array<std::string_view, 15> reference_order{
    "t_day",           "eta_mean",        "eta_centre", "nu_mean",   "nu_centre",
    "xi_mean",         "xi_centre",       "zeta_mean",  "mu_mean",   "mu_centre",
    "eta_healthy_min", "eta_healthy_max", "zeta_far",   "V_over_V0", "wall_displacement_mm"};

std::size_t place(const Column& column) {
  return static_cast<std::size_t>(std::ranges::find(reference_order, column.name) -
                                  reference_order.begin());
}

}  // namespace

std::string history_csv(const std::vector<HistoryRow>& history, const healing::Model& model) {
  std::vector<Column> all = columns(history, model);
  std::ranges::stable_sort(all, {}, place);
  std::string text;
  for (std::size_t c = 0; c < all.size(); ++c) {
    text += (c == 0 ? "" : ",") + all[c].name;
  }
  text += '\n';
  for (std::size_t r = 0; r < history.size(); ++r) {
    for (std::size_t c = 0; c < all.size(); ++c) {
      text += fmt::format("{}{:.9g}", c == 0 ? "" : ",", all[c].values[r]);
    }
    text += '\n';
  }
  return text;
}

}  // namespace sanatrix::recovery
