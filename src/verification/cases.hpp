// Where the cases are: each of these functions adds those of one file.
#pragma once

#include "verification/case.hpp"

namespace sanatrix::verification {

void add_mechanics_mms(std::vector<Case>& cases);   ///< manufactured solutions
void add_healing_mms(std::vector<Case>& cases);     ///< manufactured solutions
void add_closed_forms(std::vector<Case>& cases);    ///< C5, C6, C10
void add_cook(std::vector<Case>& cases);            ///< C8
void add_membrane(std::vector<Case>& cases);        ///< C7
void add_round_trip(std::vector<Case>& cases);      ///< C10
void add_waves(std::vector<Case>& cases);           ///< C1, C2
void add_healthy_tissue(std::vector<Case>& cases);  ///< C3
void add_spheres(std::vector<Case>& cases);         ///< C4, C11
void add_peers(std::vector<Case>& cases);           ///< the shared hemisphere
void add_patient(std::vector<Case>& cases);         ///< mesh and time convergence of outputs
void add_paper(std::vector<Case>& cases);           ///< A1-A6
void add_clinical(std::vector<Case>& cases);        ///< B1

}  // namespace sanatrix::verification
