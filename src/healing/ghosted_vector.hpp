// PETSc vectors of the own vertices that carry room for the ghosts behind them.
#pragma once

#include <span>
#include <vector>

#include "healing/system.hpp"

struct _p_Vec;  // PETSc's Vec is a pointer to this  NOLINT(bugprone-reserved-identifier)

namespace sanatrix::healing {

/// Over all processes where the mesh is shared, else of this one alone. Collective. The caller
/// destroys it.
_p_Vec* create_ghosted(const System& system);
/// Brings the ghosts up to date with their owners. Collective.
void update_ghosts(_p_Vec* v);

/// Own values and ghosts of a vector for as long as the object lives.
class LocalValues {
 public:
  explicit LocalValues(_p_Vec* v);
  ~LocalValues();
  LocalValues(const LocalValues&) = delete;
  LocalValues& operator=(const LocalValues&) = delete;
  [[nodiscard]] std::span<double> with_ghosts() const { return all_; }
  [[nodiscard]] std::span<double> own() const { return own_; }

 private:
  _p_Vec* vector_;
  _p_Vec* local_ = nullptr;
  std::span<double> all_, own_;
};

}  // namespace sanatrix::healing
