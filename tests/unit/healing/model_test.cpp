// Presets and source terms: derived constants, exact Jacobians, steady health, refusals.
#include "healing/model.hpp"

#include <cmath>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.hpp"
#include "healing/adapter.hpp"
#include "healing/five_species.hpp"
#include "healing/values.hpp"

namespace sanatrix::healing {
namespace {

using ::testing::AllOf;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

FiveSpecies::Parameters default_parameters() {
  return {.regulation = FiveSpecies::Regulation::Activator,
          .eta0 = 1e12,
          .zeta0 = 1e-5,
          .v0 = 7000.0,
          .mu0 = 1e-5,
          .eta_init = 0.01,
          .zeta_init = 1.0,
          .xi_init = 0.0,
          .healthy_clamp = true,
          .d_eta = 5e-13,
          .d_zeta = 1.25e-10,
          .d_v = 5e-12,
          .d_xi = 2e-9,
          .d_mu = 1e-10,
          .k = 6.3e-6,
          .chi = 40.0,
          .h2 = 0.8,
          .h0 = 1.25,
          .l = 8.3e-5,
          .beta_v0 = 1.16e-6,
          .lambda = 4e-5,
          .xi_tilde = 0.3,
          .xi_hat = 1.0,
          .phi = 1e-5,
          .phi_xi = 2e-9,
          .wound = {200.0, 200.0, 1e4, 830.0, 1e-3}};
}

template <class F>
Error error_of(F&& f) {
  try {
    f();
  } catch (const Error& e) {
    return e;
  }
  ADD_FAILURE() << "nothing was thrown";
  return {Fault::Internal, ""};
}

TEST(AFiveSpeciesModel, DerivesTheConstantsThatHealthImposes) {
  const FiveSpecies model(default_parameters());  // expected: PARAMETERS.md sections 1 and 2
  EXPECT_NEAR(model.derived().h1, 4.0025, 1e-12);
  EXPECT_NEAR(model.derived().k_zeta, 6.3e-18, 1e-29);
  EXPECT_NEAR(model.derived().l_eta, 8.3e-22, 1e-33);
  EXPECT_NEAR(model.derived().lambda_o, 4e-5 / 7000.0, 1e-20);
  EXPECT_NEAR(model.mitosis(0.0), 0.8, 1e-15);
  EXPECT_NEAR(model.mitosis(1.0), 1.0, 1e-14);
  EXPECT_NEAR(model.mitosis(40.0), 4.8025, 1e-12);  // the peak, h1 + h2
}

TEST(AFiveSpeciesModel, ReproducesTheActivatorOfSherrattAndMurray) {
  auto p = default_parameters();
  p.h2 = (1.0 + 1600.0 - 2.0 * 10.0 * 40.0) / (39.0 * 39.0);  // beta for h = 10, c_m = 40
  const FiveSpecies model(p);
  EXPECT_NEAR(p.h2, 0.52663, 1e-5);
  EXPECT_NEAR(model.derived().h1, 9.47337, 1e-5);
  EXPECT_NEAR(model.mitosis(0.1), model.mitosis(16000.0), 1e-12);  // zeta/zeta_bar -> its inverse
}

TEST(AFiveSpeciesModel, InhibitsFromH0DownToOne) {
  auto p = default_parameters();
  p.regulation = FiveSpecies::Regulation::Inhibitor;
  const FiveSpecies model(p);
  EXPECT_DOUBLE_EQ(model.mitosis(0.0), 1.25);
  EXPECT_DOUBLE_EQ(model.mitosis(1.0), 1.0);
}

TEST(AFiveSpeciesModel, RefusesAnUnstableHealthyState) {
  auto p = default_parameters();
  p.xi_hat = 1.2;  // healthy oxygen would count as hypoxia
  EXPECT_EQ(error_of([&] { adapt("broken", "", FiveSpecies(p))->check_steady_state(); }).fault(),
            Fault::Internal);
}

TEST(Presets, AreTheThreeOfTheParameterStudy) {
  EXPECT_THAT(preset_names(),
              ElementsAre("clinical_kader", "vavourakis2016", "vavourakis2016_inhibitor"));
}

TEST(Presets, TellMechanicsWhatAWoundIs) {
  const auto paper = make_model("vavourakis2016");
  EXPECT_EQ(paper->name(), "vavourakis2016");
  EXPECT_DOUBLE_EQ(paper->mechanics().c1, 200.0);
  EXPECT_DOUBLE_EQ(paper->mechanics().c2, 200.0);
  EXPECT_DOUBLE_EQ(paper->mechanics().kappa, 1e4);
  EXPECT_DOUBLE_EQ(paper->mechanics().active_stress, 830.0);
  EXPECT_DOUBLE_EQ(paper->mechanics().integrity_floor, 1e-3);
  const auto clinical = make_model("clinical_kader");
  EXPECT_DOUBLE_EQ(clinical->mechanics().kappa, 1e3);
  EXPECT_DOUBLE_EQ(clinical->mechanics().active_stress, 2120.0);
  EXPECT_DOUBLE_EQ(clinical->mechanics().c1, 200.0);  // the rest as in the default
  EXPECT_DOUBLE_EQ(clinical->species()[0].wounded, 0.0504);
}

TEST(Presets, TakeOverrides) {
  const auto model =
      make_model("vavourakis2016", std::vector<std::string>{"D_eta=4e-13", "T0=900"});
  EXPECT_DOUBLE_EQ(model->species()[0].diffusivity, 4e-13);
  EXPECT_DOUBLE_EQ(model->mechanics().active_stress, 900.0);
  const auto literal =
      make_model("vavourakis2016", std::vector<std::string>{"zeta_init=0", "healthy_clamp=0"});
  EXPECT_DOUBLE_EQ(literal->species()[1].healthy, 0.0);
  EXPECT_FALSE(literal->species()[0].clamped_outside);
}

TEST(Presets, RefuseWhatTheyDoNotKnowAndSayWhatTheyKnow) {
  const auto of = [](const std::string& preset, const std::string& entry) {
    return error_of([&] { make_model(preset, std::vector<std::string>{entry}); });
  };
  const Error preset = of("olsen1995", "k=1");
  EXPECT_EQ(preset.fault(), Fault::Input);
  EXPECT_THAT(preset.one_line(), AllOf(HasSubstr("olsen1995"), HasSubstr("clinical_kader")));
  EXPECT_THAT(of("vavourakis2016", "D_etta=1").one_line(),
              AllOf(HasSubstr("D_etta"), HasSubstr("D_eta, ")));
  EXPECT_THAT(of("vavourakis2016", "k 1").what(), HasSubstr("key=value"));
  EXPECT_THAT(of("vavourakis2016", "k=fast").what(), HasSubstr("not a number"));
  EXPECT_THAT(of("vavourakis2016", "k=-1").what(), HasSubstr("outside its range"));
  EXPECT_THAT(of("vavourakis2016", "xi_hat=1.2").what(), HasSubstr("outside its range"));
  EXPECT_THAT(of("vavourakis2016", "regulation=both").what(), HasSubstr("activator, inhibitor"));
}

class EveryPreset : public ::testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Presets, EveryPreset, ::testing::ValuesIn(preset_names()));

TEST_P(EveryPreset, HasTheExactJacobianOfItsSource) {
  const auto model = make_model(GetParam());
  const std::size_t n = model->species().size();
  std::mt19937 random(3);
  std::uniform_real_distribution<double> state(0.02, 1.5);
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<double> q(n), dq(n), jac(n * n), up(n), down(n);
    std::ranges::generate(q, [&] { return state(random); });
    const std::vector<double> wound{0.25 * (trial % 5)};
    model->source(q, wound, dq, jac);
    for (std::size_t j = 0; j < n; ++j) {
      const double h = 1e-5;
      auto shifted = q;
      shifted[j] = q[j] + h;
      model->source(shifted, wound, up, {});
      shifted[j] = q[j] - h;
      model->source(shifted, wound, down, {});
      for (std::size_t i = 0; i < n; ++i) {
        // Central differences: h^2 truncation plus round-off / h, at rates up to 2e-4 1/s.
        EXPECT_NEAR((up[i] - down[i]) / (2.0 * h), jac[i * n + j], 1e-12) << i << ' ' << j;
      }
    }
  }
}

TEST_P(EveryPreset, KeepsHealthyTissueAsItIs) {
  const auto model = make_model(GetParam());
  EXPECT_NO_THROW(model->check_steady_state());
  EXPECT_DOUBLE_EQ(model->cells(std::vector<double>{0.3, 1, 1, 1, 0}), 0.3);
}

TEST(TheJacobian, IsExactOnBothSidesOfTheOxygenThresholds) {
  const FiveSpecies model(default_parameters());
  for (const double xi : {0.1, 0.29, 0.31, 0.99, 1.01}) {
    const auto at = [&](double shift) {
      return model.source(std::array{0.4, 0.7, 0.3, xi + shift, 5.0}, 1.0);
    };
    std::array<Jet<5>, 5> q{0.4, 0.7, 0.3, Jet<5>::variable(xi, 3), 5.0};
    const auto exact = model.source(q, 1.0);
    for (std::size_t i = 0; i < 5; ++i) {
      EXPECT_NEAR((at(1e-6)[i] - at(-1e-6)[i]) / 2e-6, exact[i].slope[3], 1e-13);
    }
  }
}

}  // namespace
}  // namespace sanatrix::healing
