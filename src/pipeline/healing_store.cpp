#include "pipeline/healing_store.hpp"

#include <fmt/format.h>

#include "core/archive.hpp"
#include "pipeline/artefacts.hpp"

namespace sanatrix::pipeline {
namespace {

constexpr std::size_t scalars_per_row = 8;

void put_history(const std::vector<recovery::HistoryRow>& history, Archive& archive) {
  archive.reals["history"] = flatten(history);
  const std::size_t species = history.empty() ? 0 : history.front().species.mean.size();
  archive.integers["species"] = {static_cast<std::int64_t>(species)};
}

std::vector<recovery::HistoryRow> get_history(const Archive& archive) {
  return history_from(archive.real("history"),
                      static_cast<std::size_t>(archive.integer("species").at(0)));
}

}  // namespace

std::vector<double> flatten(const std::vector<recovery::HistoryRow>& history) {
  std::vector<double> flat;
  for (const recovery::HistoryRow& row : history) {
    const healing::SpeciesRecord& s = row.species;
    flat.insert(flat.end(), {s.t_day, s.eta_healthy_min, s.eta_healthy_max, s.far_field_second,
                             row.volume_ratio, row.max_displacement_mm, row.wall_displacement_mm,
                             row.min_jacobian});
    flat.insert(flat.end(), s.mean.begin(), s.mean.end());
    flat.insert(flat.end(), s.centre.begin(), s.centre.end());
  }
  return flat;
}

std::vector<recovery::HistoryRow> history_from(std::span<const double> numbers,
                                               std::size_t species) {
  std::vector<recovery::HistoryRow> history;
  for (auto at = numbers.begin(); at != numbers.end();) {
    recovery::HistoryRow row;
    row.species.t_day = at[0];
    row.species.eta_healthy_min = at[1];
    row.species.eta_healthy_max = at[2];
    row.species.far_field_second = at[3];
    row.volume_ratio = at[4];
    row.max_displacement_mm = at[5];
    row.wall_displacement_mm = at[6];
    row.min_jacobian = at[7];
    at += scalars_per_row;
    const auto count = static_cast<std::ptrdiff_t>(species);
    row.species.mean.assign(at, at + count);
    at += count;
    row.species.centre.assign(at, at + count);
    at += count;
    history.push_back(std::move(row));
  }
  return history;
}

void save_checkpoint(const recovery::Checkpoint& checkpoint, const std::filesystem::path& file) {
  Archive archive;
  archive.reals["t_s"] = {checkpoint.t_s};
  archive.reals["species"] = checkpoint.species;
  archive.reals["nodes"] = flatten(checkpoint.shape.nodes);
  archive.reals["pressure"] = checkpoint.shape.pressure;
  archive.reals["wound_volume_m3"] = {checkpoint.wound_volume_m3};
  archive.reals["earlier_nodes"] = flatten(checkpoint.earlier.nodes);
  archive.reals["earlier_pressure"] = checkpoint.earlier.pressure;
  archive.reals["earlier_density"] = {checkpoint.earlier_density};
  put_history(checkpoint.history, archive);
  archive.save(file);
}

recovery::Checkpoint load_checkpoint(const std::filesystem::path& file) {
  const Archive archive = Archive::load(file);
  return {.t_s = archive.real("t_s").at(0),
          .wound_volume_m3 = archive.real("wound_volume_m3").at(0),
          .species = archive.real("species"),
          .shape = {unflatten(archive.real("nodes")), archive.real("pressure")},
          .earlier = {unflatten(archive.real("earlier_nodes")), archive.real("earlier_pressure")},
          .earlier_density = archive.real("earlier_density").at(0),
          .history = get_history(archive)};
}

void save_frame(const Frame& frame, const std::filesystem::path& file) {
  Archive archive;
  archive.reals["t_day"] = {frame.t_day};
  archive.reals["species"] = frame.species;
  archive.reals["points"] = flatten(frame.points);
  archive.save(file);
}

Frame load_frame(const std::filesystem::path& file) {
  const Archive archive = Archive::load(file);
  return {archive.real("t_day").at(0), archive.real("species"), unflatten(archive.real("points"))};
}

std::string frame_name(double t_day) {
  return fmt::format("day_{:07.3f}", t_day);
}

void save_history(const std::vector<recovery::HistoryRow>& history,
                  const std::filesystem::path& file) {
  Archive archive;
  put_history(history, archive);
  archive.save(file);
}

std::vector<recovery::HistoryRow> load_history(const std::filesystem::path& file) {
  return get_history(Archive::load(file));
}

std::vector<double> flatten(const std::vector<mechanics::Tissue>& tissue) {
  std::vector<double> numbers;
  numbers.reserve(numbers_per_tissue * tissue.size());
  for (const mechanics::Tissue& t : tissue) {
    numbers.insert(numbers.end(), {t.c1, t.c2, t.kappa, t.density, t.integrity, t.active_stress,
                                   t.shrinkage, t.guard});
  }
  return numbers;
}

std::vector<mechanics::Tissue> tissue_from(std::span<const double> numbers) {
  std::vector<mechanics::Tissue> tissue(numbers.size() / numbers_per_tissue);
  for (std::size_t i = 0; i < tissue.size(); ++i) {
    const auto v = numbers.subspan(numbers_per_tissue * i, numbers_per_tissue);
    tissue[i] = {v[0], v[1], v[2], v[3], v[4], v[5], v[6], v[7]};
  }
  return tissue;
}

void save_tissue(std::vector<double> numbers, const std::filesystem::path& file) {
  Archive archive;
  archive.reals["tissue"] = std::move(numbers);
  archive.save(file);
}

std::vector<double> load_tissue(const std::filesystem::path& file) {
  return Archive::load(file).real("tissue");
}

}  // namespace sanatrix::pipeline
