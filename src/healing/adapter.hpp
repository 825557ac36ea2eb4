// Turns a plain struct with one templated source formula into a Model. To add a model: write such a
// struct, give it a reader from Values, and list it in the registry of presets.cpp.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <memory>
#include <string>
#include <utility>

#include "core/error.hpp"
#include "healing/jet.hpp"
#include "healing/model.hpp"

namespace sanatrix::healing {

/// What such a struct offers: n species, their source [1/s] for doubles and jets, the steady state
/// of healthy tissue, and what mechanics asks of it.
template <class M>
concept ReactionModel = requires(const M& m, const std::array<double, M::n>& q,
                                 const std::array<Jet<M::n>, M::n>& jets, double wound) {
  { m.species() } -> std::same_as<std::array<Species, M::n>>;
  { m.source(q, wound) } -> std::same_as<std::array<double, M::n>>;
  { m.source(jets, wound) } -> std::same_as<std::array<Jet<M::n>, M::n>>;
  { m.rest() } -> std::same_as<std::array<double, M::n>>;
  { m.cells(q) } -> std::same_as<double>;
  { m.mechanics() } -> std::same_as<WoundMechanics>;
};

template <ReactionModel M>
class Adapter final : public Model {
 public:
  static constexpr std::size_t n = M::n;

  Adapter(std::string name, std::string citation, M model)
      : name_(std::move(name)),
        citation_(std::move(citation)),
        model_(std::move(model)),
        species_(model_.species()),
        mechanics_(model_.mechanics()) {}

  [[nodiscard]] std::string_view name() const override { return name_; }
  [[nodiscard]] std::string_view source() const override { return citation_; }
  [[nodiscard]] std::span<const Species> species() const override { return species_; }
  [[nodiscard]] const WoundMechanics& mechanics() const override { return mechanics_; }

  void source(std::span<const double> q, std::span<const double> wound, std::span<double> dq,
              std::span<double> jac) const override {
    for (std::size_t p = 0; p < wound.size(); ++p) {
      if (jac.empty()) {
        std::array<double, n> x;
        std::copy_n(q.begin() + p * n, n, x.begin());
        std::ranges::copy(model_.source(x, wound[p]), dq.begin() + p * n);
        continue;
      }
      std::array<Jet<n>, n> x;
      for (std::size_t i = 0; i < n; ++i) {
        x[i] = Jet<n>::variable(q[p * n + i], i);
      }
      const auto rate = model_.source(x, wound[p]);
      for (std::size_t i = 0; i < n; ++i) {
        dq[p * n + i] = rate[i].value;
        std::ranges::copy(rate[i].slope, jac.begin() + (p * n + i) * n);
      }
    }
  }

  [[nodiscard]] double cells(std::span<const double> q) const override {
    std::array<double, n> x;
    std::copy_n(q.begin(), n, x.begin());
    return model_.cells(x);
  }

  void check_steady_state() const override {
    const auto rest = model_.rest();
    for (const double wound : {0.0, 1.0}) {
      std::array<double, n> dq;
      std::array<double, n * n> jac;
      source(rest, std::array{wound}, dq, jac);
      for (std::size_t i = 0; i < n; ++i) {
        double rate = 0.0;  // fastest rate of this species: the measure for "zero"
        for (std::size_t j = 0; j < n; ++j) {
          rate = std::max(rate, std::abs(jac[i * n + j]));
        }
        ensure(std::abs(dq[i]) <= 1e-12 * rate,
               "healing model {}: healthy tissue is not steady, d({})/dt = {:.3e} 1/s", name_,
               species_[i].key, dq[i]);
      }
    }
    if constexpr (requires { model_.check(); }) {
      model_.check();
    }
  }

 private:
  std::string name_, citation_;
  M model_;
  std::array<Species, n> species_;
  WoundMechanics mechanics_;
};

template <ReactionModel M>
std::unique_ptr<Model> adapt(std::string name, std::string citation, M model) {
  return std::make_unique<Adapter<M>>(std::move(name), std::move(citation), std::move(model));
}

}  // namespace sanatrix::healing
