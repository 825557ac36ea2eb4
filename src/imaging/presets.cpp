// The label tables of the known sources.
#include "imaging/presets.hpp"

#include <array>

#include "core/error.hpp"

namespace sanatrix::imaging {
namespace {

LabelTable sanatrix_table() {
  using enum Label;
  return {.name = "sanatrix",
          .tissue = {{Air, 0},
                     {Adipose, 0},
                     {Fibroglandular, 1},
                     {Skin, 0},
                     {Muscle, 0},
                     {Bone, 0},
                     {Lung, 0},
                     {Organ, 0},
                     {Tumour, 1},
                     {Nipple, 1},
                     {Vessel, 0}}};
}

/// Pelicano et al., doi:10.3390/s21248265 and doi:10.1371/journal.pone.0302974. The files hold the
/// published label + 4: tumours, skin, chest-wall sheet, background, then seven levels of one
/// monotone scale from fibroglandular to fat.
LabelTable pelicano_table() {
  using enum Label;
  LabelTable table{.name = "pelicano",
                   .tissue = {{Tumour, 1}, {Tumour, 1}, {Skin, 0}, {Muscle, 0}, {Air, 0}},
                   .sheet_only = true,
                   .skin_limit_mm = 2.0,
                   .half_height_mm = 90.0};
  constexpr std::array<double, 7> water{1.0, 0.86, 0.68, 0.50, 0.30, 0.14, 0.04};
  // The least fatty of the three levels that the source still calls fat: no gland up to here.
  constexpr double adipose_water = 0.30;
  for (const double w : water) {
    const double fraction = std::max(0.0, (w - adipose_water) / (1.0 - adipose_water));
    table.tissue.push_back({w > 0.5 ? Fibroglandular : Adipose, fraction});
  }
  return table;
}

}  // namespace

const LabelTable& label_table(LabelPreset preset) {
  static const LabelTable sanatrix = sanatrix_table();
  static const LabelTable pelicano = pelicano_table();
  return preset == LabelPreset::Pelicano ? pelicano : sanatrix;
}

LabelPreset parse_label_preset(const std::string& name) {
  for (const LabelPreset preset : {LabelPreset::Sanatrix, LabelPreset::Pelicano}) {
    if (label_table(preset).name == name) {
      return preset;
    }
  }
  throw Error(Fault::Usage, fmt::format("labels preset '{}' is not known", name),
              "use sanatrix or pelicano");
}

}  // namespace sanatrix::imaging
