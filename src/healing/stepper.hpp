// One way of advancing a System in time: CVODE, or the paper's explicit Euler. Collective calls.
#pragma once

#include <memory>
#include <span>

#include "healing/system.hpp"

namespace sanatrix::healing {

class Stepper {
 public:
  virtual ~Stepper() = default;
  /// Begins at t with the given own unknowns, forgetting all that went before.
  virtual void start(double t, std::span<const double> own_state) = 0;
  /// Takes one step that does not go beyond t_end; returns the new time.
  virtual double step(double t_end) = 0;
  /// The own unknowns at a time within the last step.
  virtual void state_at(double t, std::span<double> own_state) = 0;
};

std::unique_ptr<Stepper> make_cvode(System& system, double relative_tolerance);
/// Error{Input} naming the limit when dt is above it.
std::unique_ptr<Stepper> make_explicit(System& system, const Model& model, double dt);

}  // namespace sanatrix::healing
