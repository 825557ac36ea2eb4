// What the names that technicians give a series say about it. Scanners have no other place for some
// of it; what the header states in coded form counts besides.
#pragma once

#include <string>

namespace sanatrix::io {

/// "T1 FatSat", "t2_tirm", "ax spair", "T1 fs"; not "T1 non-fat-sat", "without FS".
bool names_fat_suppression(const std::string& description);

/// Diffusion, or computed from other images: "SUB_1", "MIP", "ADC", "dixon_W".
bool names_computed_image(const std::string& description);

bool names_localizer(const std::string& description);

}  // namespace sanatrix::io
