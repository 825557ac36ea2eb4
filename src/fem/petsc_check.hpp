// Turns PETSc's error codes into errors of ours.
#pragma once

#include <petscsys.h>

#include "core/error.hpp"

namespace sanatrix::fem {

inline void check(PetscErrorCode code, const char* doing) {
  if (code != 0) {
    const char* text = nullptr;
    PetscErrorMessage(code, &text, nullptr);
    throw Error(Fault::Internal, fmt::format("PETSc failed while {}: {}", doing,
                                             text != nullptr ? text : "unknown error"));
  }
}

}  // namespace sanatrix::fem
