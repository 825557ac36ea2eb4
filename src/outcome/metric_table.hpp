// The cosmetic indices in the order in which they are shown: names, noise floors, what is usual.
// Formulas: docs/theory/outcome.md, section 3
#pragma once

#include <array>

namespace sanatrix::outcome {

struct Definition {
  const char *key, *group, *name, *unit;
  double floor;
  const char *floor_source, *reference, *source;
};

inline constexpr auto drift = "nipples drift 4.1-6.6 mm after the bra comes off (Scurr 2015)";
inline constexpr auto scan_noise = "assumed: a surface scan repeats within 1 mm";
inline constexpr auto landmarks = "landmarks are placed within 2.5 mm (assumed)";
inline constexpr auto volume_noise = "3-D volumes repeat within 56 cm3 (doi:10.1089/lrb.2022.0015)";
inline constexpr auto percent_drift = "4.1 mm of about 200 mm (Scurr 2015)";
inline constexpr auto ratio_drift = "4.1 mm of about 80 mm (Scurr 2015)";
inline constexpr auto bcct = "as in BCCT.core (doi:10.1007/s10549-008-0173-4)";
inline constexpr auto tape = "a tape measures along the skin: the shortest way on the model's skin";
inline constexpr auto m_source = "IJROBP 2016;97:894, PMC5685181, Fig 1";

inline constexpr std::array definitions{
    Definition{"volume_treated_cm3", "size", "volume of the treated breast", "cm3", 56,
               volume_noise, "", "sum over the model's breast"},
    Definition{"volume_symmetry_pct", "size", "volume symmetry", "%", 4.1,
               "3-D volumes repeat within 4.1 % (doi:10.1089/lrb.2022.0015)",
               "after conserving surgery 87 (78-93)", "O'Connell 2017, PMC5487698"},
    Definition{"volume_asymmetry_pct", "size", "volume asymmetry", "%", 4.1,
               "3-D volumes repeat within 4.1 % (doi:10.1089/lrb.2022.0015)", "unusual beyond 25",
               "Stahl 2023, Arch Plast Surg 47:2242"},
    Definition{"excised_pct", "size", "share of the breast removed", "%", 0, "",
               "below 10: 83.5 % very satisfied; from 10: 37.0 %",
               "Cochrane 2003, doi:10.1002/bjs.4344"},
    Definition{"rms_asymmetry_mm", "shape", "surface asymmetry (RMS)", "mm", 1, scan_noise,
               "after conserving surgery 5.9 (4.2-8.0); healthy 5.9",
               "O'Connell 2017, PMC5487698; Losken 2005"},
    Definition{"retraction_mm", "shape", "deepest retraction", "mm", 1, scan_noise, "",
               "largest inward motion along the skin's normal, mean over 3 mm"},
    Definition{"retraction_p95_mm", "shape", "retraction, 95th percentile", "mm", 1, scan_noise, "",
               "over the treated breast's skin"},
    Definition{"retraction_area3_cm2", "shape", "area retracted more than 3 mm", "cm2", 1,
               "assumed: one triangle of the model's skin", "", "over the treated breast's skin"},
    Definition{"retraction_area5_cm2", "shape", "area retracted more than 5 mm", "cm2", 1,
               "assumed: one triangle of the model's skin", "", "over the treated breast's skin"},
    Definition{"below_mirrored_mm", "shape", "deepest place below the mirrored other breast", "mm",
               1, scan_noise, "", "distance from the mirrored other breast, mean over 3 mm"},
    Definition{"bod_cm2", "shape", "overlap difference (BOD)", "cm2", 2, landmarks, "", bcct},
    Definition{"bad_cm2", "shape", "area difference (BAD)", "cm2", 2, landmarks, "", bcct},
    Definition{"pbod_pct", "shape", "overlap difference / mean area", "%", 2, landmarks, "", bcct},
    Definition{"pbad_pct", "shape", "area difference / mean area", "%", 2, landmarks, "", bcct},
    Definition{"bra_mm", "nipple", "breast retraction assessment (BRA)", "mm", 4.1, drift,
               "healthy 12 +- 7; treated 37 +- 21; from 26 worth naming",
               "Pezner 1985, PubMed 3972667"},
    Definition{"pbra_pct", "nipple", "BRA / notch-nipple distance", "%", 2, percent_drift, "",
               "Van Limbergen 1989"},
    Definition{"pbra3d_pct", "nipple", "BRA in 3-D / notch-nipple distance", "%", 2, percent_drift,
               "", "Kawale 2011"},
    Definition{"unr_mm", "nipple", "upward nipple retraction, treated - other (UNR)", "mm", 4.1,
               drift, "", bcct},
    Definition{"nipple_moved_mm", "nipple", "nipple displacement", "mm", 4.1, drift, "",
               "of the same skin point"},
    Definition{"nipple_up_mm", "nipple", "- upwards", "mm", 4.1, drift, "",
               "of the same skin point"},
    Definition{"nipple_lateral_mm", "nipple", "- to the side", "mm", 4.1, drift, "",
               "of the same skin point"},
    Definition{"nipple_forward_mm", "nipple", "- forwards", "mm", 4.1, drift, "",
               "of the same skin point"},
    Definition{"nipple_turned_deg", "nipple", "nipple turned by", "deg", 5,
               "assumed: normals of the skin within 12 mm", "", "mean normal around the nipple"},
    Definition{"notch_nipple_pct", "nipple", "notch-nipple asymmetry", "%", 2, percent_drift,
               "healthy 3.2; 41 % of women differ by more than 5 mm",
               "Losken 2005; Cheong 2019, GOX 7:e2297"},
    Definition{"nipple_above_fold_treated_mm", "nipple", "nipple above the fold, treated", "mm",
               4.1, drift, "", "Regnault 1976"},
    Definition{"nipple_above_fold_other_mm", "nipple", "nipple above the fold, other", "mm", 4.1,
               drift, "", "Regnault 1976"},
    Definition{"notch_nipple_treated_mm", "length", "notch to nipple, treated, straight", "mm", 4.1,
               drift, "", tape},
    Definition{"notch_nipple_treated_skin_mm", "length", "notch to nipple, treated, along the skin",
               "mm", 4.1, drift, "", tape},
    Definition{"notch_nipple_other_mm", "length", "notch to nipple, other, straight", "mm", 4.1,
               drift, "", tape},
    Definition{"notch_nipple_other_skin_mm", "length", "notch to nipple, other, along the skin",
               "mm", 4.1, drift, "", tape},
    Definition{"nipple_fold_treated_mm", "length", "nipple to fold, treated, straight", "mm", 4.1,
               drift, "", tape},
    Definition{"nipple_fold_treated_skin_mm", "length", "nipple to fold, treated, along the skin",
               "mm", 4.1, drift, "", tape},
    Definition{"nipple_fold_other_mm", "length", "nipple to fold, other, straight", "mm", 4.1,
               drift, "", tape},
    Definition{"nipple_fold_other_skin_mm", "length", "nipple to fold, other, along the skin", "mm",
               4.1, drift, "", tape},
    Definition{"nipple_nipple_mm", "length", "nipple to nipple, straight", "mm", 4.1, drift, "",
               tape},
    Definition{"lbc_mm", "contour", "lower contour difference (LBC)", "mm", 4.1, drift, "", bcct},
    Definition{"bce_mm", "contour", "nipple to lower contour difference (BCE)", "mm", 4.1, drift,
               "", bcct},
    Definition{"bcd_mm", "contour", "contour length difference (BCD)", "mm", 5, landmarks, "",
               bcct},
    Definition{"plbc_pct", "contour", "LBC / notch-nipple distance", "%", 2, landmarks, "", bcct},
    Definition{"pbce_pct", "contour", "BCE / notch-nipple distance", "%", 2, landmarks, "", bcct},
    Definition{"pbcd_pct", "contour", "BCD / mean contour length", "%", 2, landmarks, "", bcct},
    Definition{"upper_pole_pct", "contour", "volume above the nipple, treated", "%", 4.1,
               "3-D volumes repeat within 4.1 % (doi:10.1089/lrb.2022.0015)",
               "ideal 45; after conserving surgery 74 (weakly related to what panels see)",
               "ABS 2017 P120"},
    Definition{"m1", "symmetry", "M1 nipple level (1: symmetric)", "", 0.05, ratio_drift, "",
               m_source},
    Definition{"m2", "symmetry", "M2 nipple to lower contour", "", 0.05, ratio_drift, "", m_source},
    Definition{"m3", "symmetry", "M3 nipple from the middle", "", 0.05, ratio_drift, "", m_source},
    Definition{"m4", "symmetry", "M4 nipple to lateral contour", "", 0.05, ratio_drift, "",
               m_source},
    Definition{"m5", "symmetry", "M5 lower contour level", "", 0.05, ratio_drift, "", m_source},
    Definition{"m6", "symmetry", "M6 lateral contour", "", 0.05, ratio_drift, "", m_source},
};

}  // namespace sanatrix::outcome
