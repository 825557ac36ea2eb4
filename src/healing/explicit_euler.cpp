// The paper's scheme: explicit Euler with a fixed step (17.28 s), kept to compare with.
#include <algorithm>
#include <cmath>
#include <limits>

#include <petscvec.h>

#include "core/error.hpp"
#include "healing/ghosted_vector.hpp"
#include "healing/stepper.hpp"

namespace sanatrix::healing {
namespace {

class ExplicitEuler final : public Stepper {
 public:
  ExplicitEuler(System& system, double dt)
      : system_(system), dt_(dt), state_(create_ghosted(system)) {}
  ~ExplicitEuler() override { VecDestroy(&state_); }
  ExplicitEuler(const ExplicitEuler&) = delete;
  ExplicitEuler& operator=(const ExplicitEuler&) = delete;

  void start(double t, std::span<const double> own_state) override {
    time_ = t;
    rate_.assign(own_state.size(), 0.0);
    std::ranges::copy(own_state, LocalValues(state_).own().begin());
  }

  double step(double t_end) override {
    update_ghosts(state_);
    const LocalValues q(state_);
    system_.rate(q.with_ghosts(), rate_);
    // The last step swallows a remainder below a millionth, which is round-off of the sum.
    const bool last = time_ + (1.0 + 1e-6) * dt_ >= t_end;
    const double dt = last ? t_end - time_ : dt_;
    for (std::size_t k = 0; k < rate_.size(); ++k) {
      q.own()[k] += dt * rate_[k];
    }
    return time_ = last ? t_end : time_ + dt_;
  }

  void state_at(double t, std::span<double> own_state) override {
    const LocalValues q(state_);
    for (std::size_t k = 0; k < rate_.size(); ++k) {
      own_state[k] = q.own()[k] - (time_ - t) * rate_[k];
    }
  }

 private:
  System& system_;
  double dt_, time_ = 0.0;
  Vec state_;
  std::vector<double> rate_;
};

}  // namespace

std::unique_ptr<Stepper> make_explicit(System& system, const Model& model, double dt) {
  const fem::MeshShare* share = system.share();
  const System::StepLimit mine = system.explicit_limit();
  const double limit = -fem::largest(share, -mine.dt);
  const int number = share == nullptr ? mine.vertex : share->vertex()[mine.vertex];
  const bool sets = mine.dt == limit;
  const auto vertex = static_cast<int>(fem::largest(share, sets ? number : -1));
  const auto species =
      static_cast<int>(fem::largest(share, sets && number == vertex ? mine.species : 0));
  if (!(dt > 0.0 && dt <= limit)) {
    throw Error(Fault::Input,
                fmt::format("explicit healing step of {} s is above the stability limit {:.4g} s, "
                            "set by {} at vertex {}",
                            dt, limit, model.species()[species].label, vertex),
                fmt::format("use dt_s={:.3g} or scheme=cvode", 0.9 * limit));
  }
  return std::make_unique<ExplicitEuler>(system, dt);
}

}  // namespace sanatrix::healing
