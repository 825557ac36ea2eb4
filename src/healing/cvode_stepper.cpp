// Variable-order BDF with Newton and preconditioned GMRES (SUNDIALS CVODE) over PETSc vectors.
#include <algorithm>
#include <cmath>

#include <cvode/cvode.h>
#include <nvector/nvector_petsc.h>
#include <petscvec.h>
#include <sunlinsol/sunlinsol_spgmr.h>

#include "core/error.hpp"
#include "healing/ghosted_vector.hpp"
#include "healing/stepper.hpp"

namespace sanatrix::healing {
namespace {

void check(int flag, const char* call) {
  if (flag < 0) {
    throw Error(Fault::Numerics, fmt::format("healing: {} failed with code {}", call, flag),
                "loosen relative_tolerance, or look for badly shaped tetrahedra in the wound");
  }
}

class Cvode final : public Stepper {
 public:
  Cvode(System& system, double relative_tolerance)
      : system_(system), relative_tolerance_(relative_tolerance) {
    vector_ = create_ghosted(system);
    MPI_Comm comm = PetscObjectComm(reinterpret_cast<PetscObject>(vector_));
    check(SUNContext_Create(&comm, &context_), "SUNContext_Create");
    state_ = N_VMake_Petsc(vector_, context_);
    output_ = N_VClone(state_);
    // Errors count per unknown of the wound: how much healthy tissue is meshed must not matter.
    const int counted =
        system.wound_unknowns() > 0 ? system.wound_unknowns() : system.all_unknowns();
    emphasis_ = std::sqrt(static_cast<double>(N_VGetLength(state_)) / static_cast<double>(counted));
  }

  ~Cvode() override {
    CVodeFree(&cvode_);
    SUNLinSolFree(solver_);
    N_VDestroy(output_);
    N_VDestroy(state_);
    VecDestroy(&vector_);
    SUNContext_Free(&context_);
  }
  Cvode(const Cvode&) = delete;
  Cvode& operator=(const Cvode&) = delete;

  void start(double t, std::span<const double> own_state) override {
    std::ranges::copy(own_state, LocalValues(vector_).own().begin());
    if (cvode_ == nullptr) {
      create(t);
    } else {
      check(CVodeReInit(cvode_, t, state_), "CVodeReInit");
    }
  }

  double step(double t_end) override {
    double t = 0.0;
    check(CVodeSetStopTime(cvode_, t_end), "CVodeSetStopTime");
    check(CVode(cvode_, t_end, output_, &t, CV_ONE_STEP), "CVode");
    return t;
  }

  void state_at(double t, std::span<double> own_state) override {
    check(CVodeGetDky(cvode_, t, 0, output_), "CVodeGetDky");
    std::ranges::copy(LocalValues(N_VGetVector_Petsc(output_)).own(), own_state.begin());
  }

 private:
  static constexpr int krylov_dimension = 20;  // enough for steps of a day on 2 mm meshes
  static constexpr int krylov_restarts = 4;    // for the rest
  // With CVODE's own settings (order 5, shares 0.1 and 0.05) the errors of Newton and GMRES look
  // like a rough solution to the error estimate of the high orders and keep the steps up to ten
  // times shorter than the solution asks for.
  static constexpr int highest_order = 3;
  static constexpr double newton_share = 0.05;   // of the tolerance of a step
  static constexpr double krylov_share = 0.005;  // of the tolerance of Newton

  void create(double t) {
    cvode_ = CVodeCreate(CV_BDF, context_);
    check(CVodeInit(cvode_, rate, t, state_), "CVodeInit");
    check(CVodeSetUserData(cvode_, this), "CVodeSetUserData");
    check(CVodeWFtolerances(cvode_, weights), "CVodeWFtolerances");
    check(CVodeSetErrHandlerFn(
              cvode_, [](int, const char*, const char*, char*, void*) {}, nullptr),
          "CVodeSetErrHandlerFn");
    check(CVodeSetMaxOrd(cvode_, highest_order), "CVodeSetMaxOrd");
    check(CVodeSetNonlinConvCoef(cvode_, newton_share), "CVodeSetNonlinConvCoef");
    solver_ = SUNLinSol_SPGMR(state_, SUN_PREC_LEFT, krylov_dimension, context_);
    SUNLinSol_SPGMRSetMaxRestarts(solver_, krylov_restarts);
    check(CVodeSetLinearSolver(cvode_, solver_, nullptr), "CVodeSetLinearSolver");
    check(CVodeSetEpsLin(cvode_, krylov_share), "CVodeSetEpsLin");
    check(CVodeSetJacTimes(cvode_, linearise, jacobian_times), "CVodeSetJacTimes");
    check(CVodeSetPreconditioner(cvode_, factorise, precondition), "CVodeSetPreconditioner");
  }

  static Cvode& self(void* user) { return *static_cast<Cvode*>(user); }

  static int rate(double, N_Vector q, N_Vector dq, void* user) {
    update_ghosts(N_VGetVector_Petsc(q));
    const LocalValues x(N_VGetVector_Petsc(q)), y(N_VGetVector_Petsc(dq));
    self(user).system_.rate(x.with_ghosts(), y.own());
    return 0;
  }

  static int weights(N_Vector q, N_Vector weight, void* user) {
    const Cvode& me = self(user);
    const LocalValues x(N_VGetVector_Petsc(q)), w(N_VGetVector_Petsc(weight));
    const double absolute = absolute_share * me.relative_tolerance_;
    for (std::size_t k = 0; k < w.own().size(); ++k) {
      w.own()[k] = me.emphasis_ / (me.relative_tolerance_ * std::abs(x.own()[k]) + absolute);
    }
    return 0;
  }

  /// Before every Newton step: a Jacobian as old as the preconditioner's costs tight tolerances
  /// dearly.
  static int linearise(double, N_Vector q, N_Vector, void* user) {
    const LocalValues x(N_VGetVector_Petsc(q));
    self(user).system_.linearise(x.own());
    return 0;
  }

  static int jacobian_times(N_Vector v, N_Vector jv, double, N_Vector, N_Vector, void* user,
                            N_Vector) {
    update_ghosts(N_VGetVector_Petsc(v));
    const LocalValues x(N_VGetVector_Petsc(v)), y(N_VGetVector_Petsc(jv));
    self(user).system_.apply(x.with_ghosts(), y.own());
    return 0;
  }

  static int factorise(double, N_Vector q, N_Vector, int jacobian_is_good, int* jacobian_renewed,
                       double gamma, void* user) {
    Cvode& me = self(user);
    if (jacobian_is_good == 0) {
      const LocalValues x(N_VGetVector_Petsc(q));
      me.system_.linearise(x.own());
    }
    *jacobian_renewed = jacobian_is_good == 0 ? 1 : 0;
    me.system_.factorise(gamma);
    return 0;
  }

  static int precondition(double, N_Vector, N_Vector, N_Vector r, N_Vector z, double, double, int,
                          void* user) {
    const LocalValues x(N_VGetVector_Petsc(r)), y(N_VGetVector_Petsc(z));
    self(user).system_.precondition(x.own(), y.own());
    return 0;
  }

  /// Absolute tolerance relative to the relative one; species are of order 1. Capillaries ahead of
  /// their front are tiny but decide when the centre of the wound is reached.
  static constexpr double absolute_share = 1e-3;

  System& system_;
  double relative_tolerance_;
  double emphasis_ = 1.0;
  SUNContext context_ = nullptr;
  Vec vector_ = nullptr;
  N_Vector state_ = nullptr, output_ = nullptr;
  void* cvode_ = nullptr;
  SUNLinearSolver solver_ = nullptr;
};

}  // namespace

std::unique_ptr<Stepper> make_cvode(System& system, double relative_tolerance) {
  return std::make_unique<Cvode>(system, relative_tolerance);
}

}  // namespace sanatrix::healing
