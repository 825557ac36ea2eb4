// A PETSc vector of the own vertices that carries room for the ghosts behind them.
#pragma once

#include <span>

#include <petscvec.h>

#include "healing/system.hpp"

namespace sanatrix::healing {

/// Collective; throws Error{Resource} when PETSc cannot allocate it.
Vec create_ghosted(const System& system);
/// Brings the ghosts up to date with their owners. Collective.
void update_ghosts(Vec v);

/// Own values (and ghosts, if any) of a vector for as long as the object lives.
class LocalValues {
 public:
  explicit LocalValues(Vec v);
  ~LocalValues();
  LocalValues(const LocalValues&) = delete;
  LocalValues& operator=(const LocalValues&) = delete;
  [[nodiscard]] std::span<double> with_ghosts() const { return {data_, size_with_ghosts_}; }
  [[nodiscard]] std::span<double> own() const { return {data_, size_}; }

 private:
  Vec vector_;
  double* data_ = nullptr;
  std::size_t size_ = 0, size_with_ghosts_ = 0;
};

}  // namespace sanatrix::healing
